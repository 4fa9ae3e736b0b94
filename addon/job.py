"""Heavy work beside Blender: a child process of the same command line, watched and stopped."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path

from ..core.errors import Cancelled, CoreError
from ..core.tetwild import python

ROOT = Path(__file__).resolve().parents[1]
LAUNCH = Path(__file__).with_name("launch.py")
REPORT, MOTION, PICTURE = "report.json", "motion.npz", "report.png"
REFUSED = 2  # the command line's status for an input that it will not take
PATIENCE = 0.5  # s that a child has to end itself before it is killed


class JobError(CoreError):
    """The child refused its input, or broke."""


@dataclass(frozen=True)
class Progress:
    """How far a child is."""

    fraction: float  # 0 to 1
    text: str
    running: bool


def calibration(case: Path, folder: Path, elements: int) -> list[str]:
    """The command line that calibrates `case` and leaves report, picture and motion in `folder`."""
    return [
        *("-m", "core", "calibrate", str(case), "--out", str(folder / REPORT)),
        *("--plot", str(folder / PICTURE), "--motion", str(folder / MOTION)),
        *("--elements", str(elements), "--progress-json"),
    ]


class Job:
    """One child: `python ARGUMENTS` with our modules in reach, started at once.

    It ends when it is stopped, and when this process does.
    """

    def __init__(self, arguments: list[str], folder: Path, threads: int = 0):
        folder.mkdir(parents=True, exist_ok=True)
        self.folder = folder
        self._told = (0.0, "Starting")
        self._errors: list[str] = []
        self._asked = 0.0
        self._child = subprocess.Popen(
            [python(), "-P", str(LAUNCH), *arguments],
            cwd=folder,
            env=_environment(threads),
            stdin=subprocess.PIPE,  # held open: the child ends when it closes
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            encoding="utf-8",
            errors="replace",
            **_apart(),
        )
        self._readers = [
            threading.Thread(target=read, args=(pipe,), daemon=True)
            for read, pipe in (
                (self._read_progress, self._child.stdout),
                (self._read_errors, self._child.stderr),
            )
        ]
        for reader in self._readers:
            reader.start()

    @property
    def progress(self) -> Progress:
        """What the child has told so far; never waits."""
        return Progress(*self._told, running=self._child.poll() is None)

    def wait(self, timeout: float | None = None) -> None:
        """Until the child has ended. Raises JobError with its own line when it refused or broke."""
        status = self._child.wait(timeout)
        for reader in self._readers:
            reader.join(PATIENCE)
        if status < 0 or (os.name == "nt" and status == signal.SIGTERM):
            raise Cancelled("Calibration: stopped. Nothing was changed.")
        if status:
            lines = [line.strip() for line in self._errors if line.strip()]
            last = lines[-1].removeprefix("ringdown: ") if lines else f"status {status}"
            raise JobError(last if status == REFUSED else f"The work broke off: {last}")

    def stop(self) -> None:
        """Ask the child and all that it started to end; insist when asked again. Never waits."""
        if self._child.poll() is None:
            now = time.monotonic()
            self._asked = self._asked or now
            _signal(self._child, kill=now - self._asked > PATIENCE)

    def cancel(self) -> None:
        """Stop the child, within a second, and wait until it is gone."""
        while self._child.poll() is None:
            self.stop()
            time.sleep(0.02)

    def _read_progress(self, pipe) -> None:
        for line in pipe:
            try:
                told = json.loads(line)
                self._told = (float(told["progress"]), str(told["text"]))
            except (ValueError, KeyError, TypeError):  # a library's own chatter
                continue

    def _read_errors(self, pipe) -> None:
        for line in pipe:
            self._errors = [*self._errors[-50:], line]


@dataclass
class Now:
    """What runs at the moment, for the panel to draw."""

    child: Job | None = None
    what: str = ""
    alone: bool = False  # the tab shows nothing else
    stop: bool = False
    said: str = ""  # in the status bar
    shown: Progress | None = (
        None  # what was last drawn: drawing it again would cost, and show nothing
    )


NOW = Now()


def _environment(threads: int) -> dict[str, str]:
    """This Python's modules for the child, and how many threads it may take (0: all)."""
    paths = [str(ROOT), *(path for path in sys.path if path)]
    found = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "PYTHONUNBUFFERED": "1"}
    if threads:
        for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
            found[name] = str(threads)
    return found


def _apart() -> dict:
    """A process group of its own, so that stopping it stops all of it and nothing else.

    It gives way to Blender's window; elsewhere than on Windows the child sees to that itself.
    """
    if os.name == "nt":
        below = subprocess.BELOW_NORMAL_PRIORITY_CLASS
        return {"creationflags": subprocess.CREATE_NO_WINDOW | below}
    return {"start_new_session": True}


def _signal(child: subprocess.Popen, kill: bool) -> None:
    if os.name == "nt":
        child.kill() if kill else child.terminate()
        return
    try:
        os.killpg(child.pid, signal.SIGKILL if kill else signal.SIGTERM)
    except ProcessLookupError:  # it ended by itself meanwhile
        return
