"""A child is watched without waiting, stopped within a second, and says why it refused."""

import time

import pytest

FAKE = """
import json, sys, time
say = lambda f, t: print(json.dumps({"progress": f, "text": t}), flush=True)
verb = sys.argv[1]
print("a library's chatter")
if verb == "refuse":
    print("case.toml: the field density is missing. Add it.", file=sys.stderr)
    sys.exit(2)
say(0.25, "meshing")
if verb == "stubborn":
    import signal
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
if verb != "finish":
    say(0.3, "stuck")
    time.sleep(60)
say(1.0, "done")
"""


@pytest.fixture
def start(tmp_path, rd):
    (tmp_path / "fake.py").write_text(FAKE)
    return lambda verb: rd.job.Job([str(tmp_path / "fake.py"), verb], tmp_path)


def wait_for(child, text):
    end = time.monotonic() + 10
    while child.progress.text != text:
        assert time.monotonic() < end, child.progress
        time.sleep(0.01)


def test_progress_is_what_the_child_said_last_and_reading_it_takes_no_time(start):
    child = start("hang")
    wait_for(child, "stuck")
    began = time.perf_counter()
    assert child.progress.fraction == 0.3
    assert child.progress.running
    assert time.perf_counter() - began < 0.01
    child.cancel()


@pytest.mark.parametrize("verb", ["hang", "stubborn"])
def test_a_cancelled_child_is_gone_within_a_second(start, verb):
    child = start(verb)
    wait_for(child, "stuck")
    began = time.perf_counter()
    child.cancel()
    assert not child.progress.running
    assert time.perf_counter() - began < 1
    with pytest.raises(Exception, match="stopped"):
        child.wait(1)


def test_a_refusal_comes_back_as_the_childs_own_line(start):
    with pytest.raises(Exception, match="density is missing") as refusal:
        start("refuse").wait(10)
    assert type(refusal.value).__name__ == "JobError"


def test_a_finished_child_raises_nothing(start):
    child = start("finish")
    child.wait(10)
    assert child.progress.text == "done"


def test_a_child_does_not_outlive_the_one_that_started_it(rd, tmp_path, start):
    child = start("hang")
    wait_for(child, "stuck")
    child._child.stdin.close()  # as the system does when Blender is gone, however it went
    with pytest.raises(Exception, match="130"):
        child.wait(5)
    assert not child.progress.running
