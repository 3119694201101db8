#!/usr/bin/env python3
"""Reads the C sources and tells what is wrong: check.py format|tidy|cppcheck [FILE...], without files all of them.

  format    not laid out as .clang-format says; `check.py format --fix` lays it out
  tidy      what clang-tidy finds with the checks of .clang-tidy
  cppcheck  what cppcheck finds, but for tests/arch/cppcheck.suppressions

tidy and cppcheck need the build folder that SSV_BUILD_DIR names (default build), configured and built.
Exit codes: 0 nothing found, 1 something found, 2 a tool is missing, 64 wrong usage.
"""
import concurrent.futures
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("SSV_BUILD_DIR", ROOT / "build"))
FOLDERS = ("firmware", "host", "sim", "tests")
VENDORED = "tests/support/unity/"
FORMAT_VERSION = re.search(r"clang-format==(\S+)", (ROOT / "tests/requirements-check.txt").read_text())[1]
BARE_METAL = {"firmware/target/board.c"}  # for a Cortex-M alone: its assembler is none of this machine's


class ToolMissing(Exception):
    pass


def tool(*names, package, path=None):
    """The first of these programs that is installed."""
    for name in names:
        if found := shutil.which(name, path=path):
            return found
    raise ToolMissing(f"{names[0]} is not installed. Run tests/run.sh, which installs it, or: {package}")


def sources(*suffixes):
    """Our own C files, as paths below the root."""
    found = (file.relative_to(ROOT).as_posix() for folder in FOLDERS for suffix in suffixes
             for file in (ROOT / folder).glob(f"**/*{suffix}"))
    return sorted(path for path in found if not path.startswith(VENDORED))


def findings_of(output):
    """The lines of a compiler-like output that name a fault, each once, with paths below the root."""
    lines = dict.fromkeys(line.replace(f"{ROOT}/", "") for line in output.splitlines())
    return [line for line in lines if re.search(r":\d+(:\d+)?: (warning|error|portability|performance)\b|^error: ", line)]


def commands():
    """{path: its entry of compile_commands.json}; one for each file, although some are built in several scalars."""
    database = BUILD / "compile_commands.json"
    if not database.is_file():
        raise ToolMissing(f"{database} is missing. Run tests/run.sh once, which configures and builds there.")
    entries = {}
    for entry in json.loads(database.read_text()):
        path = pathlib.Path(entry["file"])
        if path.is_relative_to(ROOT):
            entries.setdefault(path.relative_to(ROOT).as_posix(), entry)
    return entries


def write_database(paths, folder):
    """A compile_commands.json of these files; those that another build compiles (fuzzer, target) have the daemon's options."""
    entries, like = commands(), "firmware/daemon/answer.c"
    if like not in entries:
        raise ToolMissing(f"The build in {BUILD} is without the host's part: configure with -DSSV_BUILD_HOST=ON.")
    words = entries[like]["command"].partition(" -o ")[0]
    more = [*(ROOT / folder for folder in ("firmware", "firmware/target", "host", "host/cli", "tests/support")), BUILD / "tests/arch"]
    generated = BUILD / "firmware/link/mavlink/include"
    other = words + "".join(f" -I{folder}" for folder in more) + f" -isystem {generated}"
    made = [entries.get(path, {"directory": str(BUILD), "file": str(ROOT / path), "command": f"{other} -c {ROOT / path}"})
            for path in paths]
    for path, entry in zip(paths, made):
        entry["file"] = str(ROOT / path)
    (folder / "compile_commands.json").write_text(json.dumps(made))


def check_format(files, fix=False):
    """Findings in files, as absolute paths."""
    beside = pathlib.Path(sys.executable).parent  # where pip puts it
    program = tool("clang-format", path=f"{beside}:{os.environ['PATH']}",
                   package="pip install --require-hashes -r tests/requirements-check.txt")
    version = subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout
    if f" {FORMAT_VERSION}" not in version:
        raise ToolMissing(f"{program} is {version.strip()}, not {FORMAT_VERSION}: "
                          "pip install --require-hashes -r tests/requirements-check.txt")
    options = ["-i"] if fix else ["--dry-run", "-Werror"]
    done = subprocess.run([program, *options, f"--style=file:{ROOT}/.clang-format", *files], capture_output=True, text=True)
    findings = findings_of(done.stderr)
    return findings or ([done.stderr] if done.returncode else [])


def check_tidy(files):
    program = tool("clang-tidy", "clang-tidy-19", "clang-tidy-14", package="apt-get install clang-tidy")

    def run(file):
        done = subprocess.run([program, "--quiet", "-p", database, file], capture_output=True, text=True)
        findings = findings_of(done.stdout)
        return findings or ([done.stdout + done.stderr] if done.returncode else [])
    with tempfile.TemporaryDirectory() as database, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        write_database([os.path.relpath(file, ROOT) for file in files], pathlib.Path(database))
        return list(dict.fromkeys(finding for found in pool.map(run, files) for finding in found))


def check_cppcheck(files):
    program = tool("cppcheck", package="apt-get install cppcheck")
    with tempfile.TemporaryDirectory() as folder:
        write_database([os.path.relpath(file, ROOT) for file in files], pathlib.Path(folder))
        done = subprocess.run(
            [program, f"-j{os.cpu_count()}", "--quiet", "--enable=warning,performance,portability", "--error-exitcode=1",
             f"--project={folder}/compile_commands.json", f"--suppressions-list={ROOT}/tests/arch/cppcheck.suppressions",
             "--template={file}:{line}: {severity}: {message} [{id}]"], capture_output=True, text=True)
        findings = findings_of(done.stderr)
        return findings or ([done.stdout + done.stderr] if done.returncode else [])


def main(arguments):
    if arguments[:1] in (["-h"], ["--help"]):
        print(__doc__.strip())
        return 0
    name, *rest = arguments or [""]
    files = [str(pathlib.Path(file).resolve()) for file in rest if file != "--fix"]
    if name not in ("format", "tidy", "cppcheck") or ("--fix" in rest and name != "format"):
        print(__doc__.strip(), file=sys.stderr)
        return 64
    try:
        if name == "format":
            findings = check_format(files or [str(ROOT / path) for path in sources(".c", ".h")], "--fix" in rest)
        else:
            ours = [str(ROOT / path) for path in sources(".c") if path not in BARE_METAL]
            findings = {"tidy": check_tidy, "cppcheck": check_cppcheck}[name](files or ours)
    except ToolMissing as missing:
        print(missing, file=sys.stderr)
        return 2
    print(*findings, sep="\n", end="\n" if findings else "")
    if findings and name == "format":
        print("To lay them out: build/venv/bin/python tests/arch/check.py format --fix")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
