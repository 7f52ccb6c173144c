"""config.yaml: parsed once for a text, never shared, and refused where its settings do not say what made the run."""

from __future__ import annotations

import pytest

from slcs2_jax.config import InputError, Settings
from slcs2_jax.results import run_config
from slcs2_jax.results.run_config import RunConfig, new_record, read_config, write_config


@pytest.fixture
def folder(tmp_path):
    write_config(tmp_path, RunConfig(Settings(seed=4), new_record("evolve", "1 x cpu (cpu)", {"width": 16})))
    return tmp_path


def test_a_text_is_parsed_once_and_read_each_time(folder, monkeypatch):
    parsed = []
    parse = run_config.parse_yaml
    monkeypatch.setattr(run_config, "parse_yaml", lambda data: parsed.append(data) or parse(data))
    run_config._parsed.cache_clear()
    first, second = read_config(folder), read_config(folder)
    assert len(parsed) == 1
    assert first.settings == second.settings == Settings(seed=4)
    first.record["width"] = 3
    assert second.record["width"] == read_config(folder).record["width"] == 16, "nobody sees another's changes"
    write_config(folder, RunConfig(Settings(seed=5), second.record))
    assert read_config(folder).settings.seed == 5


def test_a_run_of_another_search_of_an_older_version_is_refused(tmp_path):
    for search in ("Search", "RandomSearch"):
        record = new_record("evolve", "1 x cpu (cpu)", {"width": 16, "search": search})
        write_config(tmp_path, RunConfig(Settings(), record))
        if search == "Search":
            assert read_config(tmp_path).settings == Settings()
            continue
        with pytest.raises(InputError, match="made by the search RandomSearch of an older slcs2_jax"):
            read_config(tmp_path)
