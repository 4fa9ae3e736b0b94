"""The clips in tests/core/phone, as phones write them; OpenCV's own writer cannot.

    python tests/core/phone_clips.py FFMPEG

FFMPEG: a program with libx265, libaom and libx264. All show `pictures()`: ten-bit HEVC held upright
at a wandering frame rate, H.264 held upside down and trimmed, and AV1, which is not decoded here.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from tests.core.clips import Swing, film

FOLDER = Path(__file__).parent / "phone"
SIZE, COUNT, RATE = (128, 96), 24, 30  # px, as stored
WANDER = 0.3  # of a frame
TRIMMED = 6  # frames at the start of the H.264 clip that its edit list hides


def pictures() -> list:
    """(height, width) uint8, as the sensor sees them."""
    return [picture[: SIZE[1], : SIZE[0]].copy() for picture in film(Swing(), np.arange(COUNT))]


def stamps() -> np.ndarray:
    """s, when the pictures of the HEVC clip are shown."""
    k = np.arange(COUNT)
    return (k + WANDER * np.sin(k)) / RATE


def main(ffmpeg: str) -> None:
    raw = b"".join(picture.tobytes() for picture in pictures())
    source = f"-f rawvideo -pix_fmt gray -s {SIZE[0]}x{SIZE[1]} -r {RATE} -i -".split()
    wandering = f"settb=1/90000,setpts='(N+{WANDER}*sin(N))/{RATE}/TB'"
    quiet = "log-level=error"
    hevc = f"-vf {wandering} -fps_mode vfr -enc_time_base 1:90000 -video_track_timescale 90000"
    hevc += f" -c:v libx265 -pix_fmt yuv420p10le -crf 22 -bf 0 -tag:v hvc1 -x265-params {quiet}"
    made = {
        "hevc.mov": hevc.replace("'", ""),
        "h264.mp4": f"-c:v libx264 -pix_fmt yuv420p -crf 22 -g {TRIMMED} -bf 0",
        "av1.mp4": "-c:v libaom-av1 -crf 50 -cpu-used 8 -pix_fmt yuv420p -frames:v 12",
    }
    for name, how in made.items():
        call = [ffmpeg, "-y", "-loglevel", "error", *source, *how.split(), FOLDER / name]
        subprocess.run(call, input=raw, check=True)
    start = f"-ss {TRIMMED / RATE:.4f}"
    for name, how in {"hevc.mov": "90", "h264.mp4": f"180 {start}"}.items():
        plain = FOLDER / f"plain_{name}"
        (FOLDER / name).rename(plain)
        call = [ffmpeg, "-y", "-loglevel", "error", "-display_rotation:v:0", *how.split()]
        call += ["-i", plain, "-c", "copy", "-video_track_timescale", "90000", FOLDER / name]
        subprocess.run(call, check=True)
        plain.unlink()


if __name__ == "__main__":
    main(sys.argv[1])
