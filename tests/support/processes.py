"""Starting and ending the programs under test: every process started here is ended here, by its own id."""
import os
import pathlib
import signal
import subprocess
import tempfile
import time

SOURCE = pathlib.Path(os.environ.get("KAWARA_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
BIN = pathlib.Path(os.environ.get("KAWARA_BIN", SOURCE / "build" / "bin"))


def run(program, *args, timeout=120, check=False, **kwargs):
    """Runs one of our programs to its end; returns CompletedProcess with text output. check: a failure is shown and raised."""
    done = subprocess.run([str(BIN / program), *map(str, args)], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True, timeout=timeout, **kwargs)
    if check and done.returncode != 0:
        raise AssertionError(f"{program} ended with {done.returncode}: {done.stderr}")
    return done


def wait_for(condition, seconds, what):
    """Polls condition() until it is true; raises with `what` otherwise. Generous: the machines are shared."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        value = condition()
        if value:
            return value
        time.sleep(0.02)
    raise TimeoutError(f"not within {seconds} s: {what}")


class Processes:
    """A context that ends what was started in it and keeps each program's output in a file."""

    def __init__(self, folder=None):
        self.folder = pathlib.Path(folder or tempfile.mkdtemp(prefix="kawara-"))
        self.folder.mkdir(parents=True, exist_ok=True)
        self.running = {}

    def __enter__(self):
        return self

    def __exit__(self, *exc):
        self.stop_all()

    def start(self, name, program, *args, env=None):
        out = open(self.folder / f"{name}.out", "ab")
        process = subprocess.Popen([str(BIN / program), *map(str, args)], stdout=out, stderr=subprocess.STDOUT,
                                   stdin=subprocess.DEVNULL, env={**os.environ, **(env or {})})
        out.close()
        self.running[name] = process
        return process

    def output(self, name):
        path = self.folder / f"{name}.out"
        return path.read_text(errors="replace") if path.exists() else ""

    def wait(self, name, timeout):
        return self.running[name].wait(timeout)

    def stop(self, name, timeout=30, sig=signal.SIGTERM):
        """Asks the program to end and returns its exit code; kills it if it does not."""
        process = self.running.pop(name)
        if process.poll() is None:
            process.send_signal(sig)
            try:
                process.wait(timeout)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
                raise
        return process.returncode

    def stop_all(self):
        for name in list(self.running):
            process = self.running.pop(name)
            if process.poll() is None:
                process.terminate()
        # give them a moment, then insist
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
