"""Episodes as animations: GIF, or MP4 where there is an encoder."""

from __future__ import annotations

import io
import itertools
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from numpy.typing import NDArray

from slcs2_jax.config import InputError
from slcs2_jax.looking.drawing import own_style
from slcs2_jax.looking.recording import Recording
from slcs2_jax.looking.scene import FATES, HOLDING, LINK, TRAIL, Scene, extent, legend_handles, panels
from slcs2_jax.results.files import write_whole
from slcs2_jax.running.memory import check_fits

SUFFIXES = (".gif", ".mp4")
STRENGTHS = (0.07, 0.14, 0.25, 0.4, 0.55, 0.7, 0.85, 1.0)  # of each colour in a GIF's palette
DPI = 100
USUAL_FRAMES, MOST_FRAMES, MOST_FPS = 300, 5000, 100


def usual_stride(steps: int) -> int:
    """Time-steps from frame to frame so that a span of so many has about `USUAL_FRAMES` frames."""
    return max(1, round(steps / USUAL_FRAMES))


def check_frames(steps: int, every: int) -> None:
    """Raise InputError if a span of so many time-steps has more than `MOST_FRAMES` frames."""
    if steps / every > MOST_FRAMES:
        raise InputError(f"every={every}: would give more than {MOST_FRAMES} frames; accepted are fewer")


def find_encoder() -> str:
    """The ffmpeg that makes MP4s: on the path, or of the package imageio-ffmpeg. Raises InputError if there is none."""
    found = shutil.which("ffmpeg")
    if found is not None:
        return found
    try:
        import imageio_ffmpeg
    except ImportError:
        raise InputError(
            "out: an .mp4 needs ffmpeg; accepted is a .gif, or an installation with ffmpeg or slcs2_jax[video]"
        ) from None
    return str(imageio_ffmpeg.get_ffmpeg_exe())


def animate(
    recordings: Sequence[Recording],
    titles: Sequence[str],
    path: Path,
    *,
    start: int,
    end: int,
    every: int,
    fps: int,
    field: str | None = None,
    after_frame: Callable[[int, int], None] = lambda done, total: None,
) -> int:
    """Write an animation of one episode, or of several in one world one above the other by the same clock.

    A frame shows a moment and every transmission since the frame before it.

    Args:
        recordings, titles: what to show, and what to call it.
        path: of the file, .gif or .mp4.
        start, end: first and last moment, steps.
        every: steps from frame to frame.
        fps: frames per second.
        field: a radio map under the rest, one of `radio_map.FIELDS`.
        after_frame: told how many of how many frames are drawn.

    Returns:
        How many frames were written.
    """
    moments = [*range(start, end, every), end]

    def frames() -> Iterator[NDArray[np.uint8]]:
        for number, picture in enumerate(_pictures(recordings, titles, moments, field), start=1):
            yield picture
            after_frame(number, len(moments))

    write = _write_gif if path.suffix == ".gif" else _write_mp4
    with own_style():
        content = write(frames(), fps, len(moments))
    write_whole(path, lambda file: file.write(content))
    return len(moments)


def _pictures(
    recordings: Sequence[Recording], titles: Sequence[str], moments: Sequence[int], field: str | None
) -> Iterator[NDArray[np.uint8]]:
    """RGB pictures, uint8 [height, width, 3], with even sides; without a radio map what stands still is drawn once."""
    figure, axes = panels(recordings, field)
    figure.set_dpi(DPI)
    canvas = FigureCanvasAgg(figure)
    within = extent(recordings)
    scenes = [Scene(ax, one, title, within, field) for ax, one, title in zip(axes, recordings, titles, strict=True)]
    handles = legend_handles(any(bool(one.down.any()) for one in recordings))
    figure.legend(handles=handles, loc="outside lower center", ncols=8, fontsize=6.5, frameon=False)
    moving = [(ax, artist) for ax, scene in zip(axes, scenes, strict=True) for artist in scene.moving]
    for _, artist in moving:
        artist.set_animated(field is None)
    canvas.draw()
    still = canvas.copy_from_bbox(figure.bbox)
    since = moments[0]
    for moment in moments:
        for scene in scenes:
            scene.show(moment, since)
        if field is None:
            canvas.restore_region(still)
            for ax, artist in moving:
                ax.draw_artist(artist)
        else:
            canvas.draw()
        yield np.array(canvas.buffer_rgba())[..., :3]
        since = moment


def _write_gif(frames: Iterator[NDArray[np.uint8]], fps: int, count: int) -> bytes:
    """All frames with one palette, so that what does not change costs nothing."""
    from PIL import Image

    first = next(frames)
    check_fits("frames", count, first.shape[0] * first.shape[1], "an animation (every= makes fewer)")
    reference = Image.new("P", (1, 1))
    reference.putpalette(_palette())
    reduced = [
        Image.fromarray(frame).quantize(palette=reference, dither=Image.Dither.NONE)
        for frame in itertools.chain([first], frames)
    ]
    buffer = io.BytesIO()
    durations = [round(1000 / fps)] * (len(reduced) - 1) + [2000]  # stay at the end for a while
    reduced[0].save(buffer, "GIF", save_all=True, append_images=reduced[1:], duration=durations, loop=0, optimize=False)
    return buffer.getvalue()


def _palette() -> list[int]:
    """Red, green and blue of greys, and of every colour of a scene in some strengths upon white."""
    colours = [name for name, _, _ in FATES.values()] + [HOLDING, LINK, TRAIL]
    found = np.repeat(np.linspace(0, 255, 32)[:, None], 3, axis=1).tolist()
    for name in colours:
        colour = np.array([int(name[at : at + 2], 16) for at in (1, 3, 5)])
        tints = [255 - strength * (255 - colour) for strength in STRENGTHS]
        found += [tint for tint in tints if tint.min() < 240]  # paler ones and white would be taken for each other
    return np.rint(found).astype(int).ravel().tolist()


def _write_mp4(frames: Iterator[NDArray[np.uint8]], fps: int, count: int) -> bytes:
    """However many frames: the encoder takes them one by one."""
    first = next(frames)
    height, width = first.shape[:2]
    with tempfile.TemporaryDirectory(prefix="slcs2-") as folder:
        file = Path(folder) / "replay.mp4"
        command = [find_encoder(), "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24"]
        command += ["-s", f"{width}x{height}", "-r", str(fps), "-i", "-"]
        command += ["-an", "-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "20", "-movflags", "+faststart", str(file)]
        with tempfile.TemporaryFile() as said:
            process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=said)
            assert process.stdin is not None
            try:
                process.stdin.write(first.tobytes())
                for frame in frames:
                    process.stdin.write(frame.tobytes())
                process.stdin.close()
            except BrokenPipeError:
                pass  # it says why
            if process.wait() != 0:
                said.seek(0)
                words = said.read().decode(errors="replace")
                raise InputError(
                    f"out: ffmpeg could not make an .mp4 ({' '.join(words.split())[:200]}); accepted is a .gif"
                )
        return file.read_bytes()
