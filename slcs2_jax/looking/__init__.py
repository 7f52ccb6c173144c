"""One episode or one run looked at: recording, replay, pictures, rules in words, the page of a run."""
