"""clang-tidy over the project's sources, side by side: lint.py BUILD_DIR JOBS [FILE...]

A file found clean is not looked at again until something it is made of changes: its text and that of every header it
includes, its flags, .clang-tidy or clang-tidy itself. So the first run takes as long as it takes, later ones seconds.
Exit code 1 with the findings on standard output if there are any.
"""
import concurrent.futures
import hashlib
import json
import pathlib
import shlex
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
# gcc's own warnings mean nothing to clang.
EXTRA = ["-Wno-unknown-warning-option"]


def flags_of(command):
    """The compile command without launcher, compiler, output and input."""
    words = shlex.split(command)
    words = words[next(i for i, w in enumerate(words) if w.startswith("-")):]
    kept, skip = [], False
    for word in words:
        if skip or word == "-c":
            skip = False
        elif word in ("-o", "-MT", "-MF"):
            skip = True
        elif word != "-MD" and not word.endswith(".cpp"):
            kept.append(word)
    return kept


def key_of(file, flags, directory, common):
    """Of everything that decides what clang-tidy says; comments count, because NOLINT is one."""
    text = subprocess.run(["clang++", "-E", "-C", *flags, *EXTRA, file], cwd=directory, capture_output=True, check=False)
    return hashlib.sha256(common + b"\0".join(f.encode() for f in flags) + text.stdout + text.stderr).hexdigest()


def lint(entry, build, common):
    file, directory = entry["file"], entry["directory"]
    clean = build / "lint" / key_of(file, flags_of(entry["command"]), directory, common)
    if clean.exists():
        return "", True
    done = subprocess.run(["clang-tidy", "-p", str(build), "--quiet", "--warnings-as-errors=*",
                           *(f"--extra-arg={e}" for e in EXTRA), file], capture_output=True, text=True, check=False)
    if done.returncode == 0:
        clean.touch()
        return "", False
    return done.stdout or done.stderr, False


def main():
    build, jobs = pathlib.Path(sys.argv[1]).resolve(), int(sys.argv[2])
    wanted = {str((ROOT / f).resolve()) for f in sys.argv[3:]}
    entries = [e for e in json.loads((build / "compile_commands.json").read_text())
               if e["file"] in wanted or (not wanted and e["file"].startswith(f"{ROOT}/")
                                          and not e["file"].startswith((f"{ROOT}/tests/", f"{build}/")))]
    (build / "lint").mkdir(exist_ok=True)
    version = subprocess.run(["clang-tidy", "--version"], capture_output=True, check=True).stdout
    common = version + (ROOT / ".clang-tidy").read_bytes()
    findings = known = 0
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for text, was_known in pool.map(lambda e: lint(e, build, common), entries):
            findings += bool(text)
            known += was_known
            if text:
                print(text, flush=True)
    print(f"clang-tidy: {len(entries)} files, {known} of them known to be clean, {findings} with findings")
    return 1 if findings or not entries else 0


if __name__ == "__main__":
    sys.exit(main())
