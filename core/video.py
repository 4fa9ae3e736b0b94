"""Clips as streams of grey pictures: what phones and cameras write, one frame at a time."""

import os
import queue
import re
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .errors import RecordingError
from .video_tags import capture_rate_tag, shown_seconds

os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")  # read once; its chatter names no remedy

import cv2  # after the line above, or ffmpeg writes to standard error

PICTURES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".exr", ".webp")
AHEAD = 8  # frames decoded before they are asked for
FEWEST_FRAMES = 12


@dataclass(frozen=True)
class Video:
    """What a clip says of itself; its frames are read with `read_frames`."""

    path: Path
    size: tuple[int, int]  # px, width and height as shown, rotation flag applied
    rate: float | None  # frames/s that the container plays at
    count: int  # frames that the container promises, 0 = it does not say
    tagged_rate: float | None = None  # frames/s of real time in the file's metadata
    pictures: tuple[Path, ...] = ()  # of an image sequence


@dataclass(frozen=True, eq=False)
class Frame:
    """One picture of a clip."""

    index: int  # 0 is the clip's first
    stamp: float  # s, presentation time; NaN where the clip has none
    grey: np.ndarray  # (height, width) uint8
    change: float  # grey levels, mean absolute difference from the frame before; NaN for the first


def open_video(path: str | Path) -> Video:
    """What the clip at `path` is: a video file, a folder of pictures, or a pattern like f_%04d.png.

    Raises RecordingError for what is absent, not a video, without frames, or a single frame.
    """
    path = Path(path)
    if path.is_dir() or "%" in path.name or "*" in path.name:
        return _open_pictures(path)
    if not path.is_file():
        raise RecordingError(f"{path}: there is no such file. Give the path of a video.")
    if path.suffix.lower() in PICTURES:
        raise RecordingError(
            f"{path.name}: one picture, a clip is needed. Give the folder of an image sequence."
        )
    capture = _capture(path)
    try:
        return _described(path, capture)
    finally:
        capture.release()


def read_frames(video: Video, first: int = 0) -> Iterator[Frame]:
    """The frames from index `first` on, grey; a thread decodes a few ahead, never the whole clip.

    The stream ends at the clip's end or where it can no longer be decoded; frames that the
    decoder gave up show as gaps between the stamps.
    """
    source = _read_pictures(video, first) if video.pictures else _read_container(video, first)
    ready: queue.Queue = queue.Queue(AHEAD)
    stopped = threading.Event()
    worker = threading.Thread(target=_fill, args=(source, ready, stopped), daemon=True)
    worker.start()
    try:
        while isinstance(frame := ready.get(), Frame):
            yield frame
        if frame is not None:
            raise frame
    finally:
        stopped.set()
        while worker.is_alive():
            _emptied(ready)
            worker.join(0.01)


def frame_at(video: Video, index: int) -> Frame:
    """The frame `index`. Raises RecordingError where the clip ends before it."""
    frames = read_frames(video, index)
    try:
        return next(frames)
    except StopIteration:
        raise RecordingError(
            f"{video.path.name}: frame {index} cannot be read; the clip ends before it. "
            "Start earlier."
        ) from None
    finally:
        frames.close()


def ended_early(video: Video, frames_read: int) -> str | None:
    """A sentence where the clip promised more frames than could be read."""
    missing = video.count - frames_read
    if missing <= max(1, video.count // 200):  # some containers round their count
        return None
    return (
        f"{video.path.name}: only {frames_read} of {video.count} frames could be read; the file is "
        f"damaged after frame {frames_read - 1}. What is there was used; copy the clip again."
    )


def _fill(source, ready, stopped) -> None:
    end = None
    try:
        for frame in source:
            ready.put(frame)
            if stopped.is_set():
                break
    except (cv2.error, RecordingError) as error:
        end = RecordingError(str(error))
    finally:
        source.close()
        ready.put(end)


def _emptied(ready) -> None:
    try:
        while True:
            ready.get_nowait()
    except queue.Empty:
        return


def _capture(path: Path):
    level = cv2.getLogLevel()
    cv2.setLogLevel(0)
    try:
        capture = cv2.VideoCapture(str(path))
    finally:
        cv2.setLogLevel(level)
    if not capture.isOpened():
        raise RecordingError(
            f"{path.name}: not a video, or too damaged to be read. Give an mp4, mov or avi, or a "
            "folder of pictures."
        )
    capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 1)  # off by default, and phones are held upright
    return capture


def _described(path: Path, capture) -> Video:
    good, picture = capture.read()
    if not good:
        raise RecordingError(
            f"{path.name}: no frame of it can be decoded (its codec is {_codec(capture)}). Save it "
            "as H.264, such as by: ffmpeg -i IN -c:v libx264 -crf 12 -fps_mode passthrough OUT.mp4"
        )
    if not capture.grab():
        raise RecordingError(
            f"{path.name}: it holds one frame; {FEWEST_FRAMES} are needed at least. Film longer."
        )
    rate, count = capture.get(cv2.CAP_PROP_FPS), capture.get(cv2.CAP_PROP_FRAME_COUNT)
    rate = float(rate) if np.isfinite(rate) and 0 < rate < 1e5 else None
    count = int(count) if 0 < count < 1e8 else 0
    shown = shown_seconds(path)
    if rate is not None and shown is not None:
        count = min(count, round(shown * rate))
    size = (picture.shape[1], picture.shape[0])
    return Video(path, size, rate, count, capture_rate_tag(path))


def _codec(capture) -> str:
    letters = int(capture.get(cv2.CAP_PROP_FOURCC)).to_bytes(4, "little", signed=True)
    name = letters.decode("ascii", "replace").strip("\0 ")
    return name if name.isprintable() and name else "unknown"


def _open_pictures(path: Path) -> Video:
    folder = path if path.is_dir() else path.parent
    pattern = "*" if path.is_dir() else re.sub(r"%0?\d*d", "*", path.name)
    found = [p for p in folder.glob(pattern) if p.suffix.lower() in PICTURES]
    pictures = tuple(sorted(found, key=lambda p: (_number(p), p.name)))
    if not pictures:
        raise RecordingError(
            f"{path}: no pictures there ({', '.join(PICTURES[:4])} ...). Give the folder of an "
            "image sequence."
        )
    if len(pictures) == 1:
        raise RecordingError(
            f"{path}: it holds one frame, {pictures[0].name}; {FEWEST_FRAMES} are needed at least."
        )
    height, width = _picture(pictures[0]).shape
    return Video(path, (width, height), None, len(pictures), pictures=pictures)


def _number(path: Path) -> int:
    """The last number in a file's name: a picture's place in the sequence."""
    digits = re.findall(r"\d+", path.stem)
    return int(digits[-1]) if digits else 0


def _picture(path: Path) -> np.ndarray:
    grey = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    if grey is None:
        raise RecordingError(f"{path.name}: a picture that cannot be read. Render it again.")
    return grey


def _read_pictures(video: Video, first: int) -> Iterator[Frame]:
    numbers = [_number(p) for p in video.pictures]
    numbered = len(set(numbers)) == len(numbers)
    before = None
    for index in range(first, len(video.pictures)):
        grey = _picture(video.pictures[index])
        stamp = float(numbers[index] - numbers[0]) if numbered else np.nan
        yield Frame(index, stamp, grey, _change(before, grey, video.pictures[index].name))
        before = grey


def _read_container(video: Video, first: int) -> Iterator[Frame]:
    capture = _capture(video.path)
    before = None
    index = 0
    try:
        while capture.grab():
            stamp = capture.get(cv2.CAP_PROP_POS_MSEC) / 1000
            if index >= first:
                good, picture = capture.retrieve()
                if not good:
                    return
                grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY) if picture.ndim == 3 else picture
                yield Frame(index, stamp, grey, _change(before, grey, f"frame {index}"))
                before = grey
            index += 1
    finally:
        capture.release()


def _change(before, grey, name) -> float:
    if before is None:
        return np.nan
    if before.shape != grey.shape:
        raise RecordingError(
            f"{name}: {grey.shape[1]} x {grey.shape[0]} px, the frame before had "
            f"{before.shape[1]} x {before.shape[0]}. Give one clip of one size."
        )
    return cv2.norm(before, grey, cv2.NORM_L1) / grey.size
