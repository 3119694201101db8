#!/usr/bin/env python3
"""Vendors the Unity test framework into a folder: fetch_unity.py [FOLDER], default tests/support/unity.

Unity comes from Debian 13's source package cmock, fetched with apt from the mirror that this machine already uses. The
system's own package lists and sources stay as they are and no root is needed. The archive is checked by its SHA-256.
Does nothing, and needs no network, when the folder already holds this version.
Exit codes: 0 the folder is complete, 1 not fetched (says why), 64 wrong usage.
"""
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile

PACKAGE = "cmock"
ARCHIVE_SHA256 = "bac41c14dc651e14b8b7ca92a6e01935dc135bc6e99be567b48f5544ab7a6347"
SUITE = "trixie"
FILES = {
    "vendor/unity/src/unity.c": "unity.c",
    "vendor/unity/src/unity.h": "unity.h",
    "vendor/unity/src/unity_internals.h": "unity_internals.h",
    "vendor/unity/LICENSE.txt": "LICENSE.txt",
}
STAMP = "archive.sha256"


class FetchError(Exception):
    pass


def source_of(text, codename, suite):
    """The part of an apt sources file that names Debian's `codename`, rewritten to the source packages of `suite`.

    Keeps the format (one line, or a deb822 stanza) and every option, so that mirror and keys are the machine's own.
    Returns None when the text does not name `codename`.
    """
    for line in text.splitlines():
        match = re.match(r"deb\s+(\[[^\]]*\]\s+)?(\S+)\s+(\S+)\s", line)
        if match and match[3] == codename and not match[2].startswith("cdrom:"):
            return f"deb-src {match[1] or ''}{match[2]} {suite} main\n"
    for stanza in re.split(r"\n\s*\n", re.sub(r"(?m)^#.*\n?", "", text)):
        fields = dict(re.findall(r"(?m)^([A-Za-z-]+):[ \t]*(.*(?:\n[ \t].*)*)", stanza))
        named = {name.lower(): value for name, value in fields.items()}
        if (codename not in named.get("suites", "").split() or "deb" not in named.get("types", "").split()
                or named.get("enabled", "yes").strip().lower() in ("no", "false", "0")):
            continue
        changed = {"types": "deb-src", "suites": suite, "components": "main"}
        return "".join(f"{name}: {changed.get(name.lower(), value.rstrip())}\n" for name, value in fields.items())
    return None


def apt_sources():
    """The machine's apt sources files, as (path, text)."""
    shell = subprocess.run(["apt-config", "shell", "LIST", "Dir::Etc::SourceList/f", "PARTS", "Dir::Etc::SourceParts/d"],
                           check=True, capture_output=True, text=True).stdout
    where = dict(re.findall(r"(\w+)='(.*)'", shell))
    parts = pathlib.Path(where["PARTS"])
    files = [pathlib.Path(where["LIST"]), *sorted(parts.glob("*.sources")), *sorted(parts.glob("*.list"))]
    return [(path, path.read_text()) for path in files if path.is_file()]


def codename():
    match = re.search(r"(?m)^VERSION_CODENAME=\"?(\w+)", pathlib.Path("/etc/os-release").read_text())
    if not match:
        raise FetchError("/etc/os-release names no Debian release")
    return match[1]


def give_to_sandbox(folder):
    """Run by root, apt fetches as a user who may do nothing else, and who must be able to write there. Returns the options
    that apt needs where there is no other user than root, as in a namespace of its own."""
    said = subprocess.run(["apt-config", "shell", "USER", "APT::Sandbox::User"], capture_output=True, text=True).stdout
    user = re.search(r"USER='([\w-]+)'", said)
    if os.geteuid() != 0 or not user:
        return []
    try:
        for path in (folder, *folder.glob("**/")):
            shutil.chown(path, user[1])
    except (OSError, LookupError):
        return ["-o", "APT::Sandbox::User="]
    return []


def download(folder):
    """Downloads the source archive into `folder` with apt, away from the system's lists. Returns its path."""
    name = codename()
    found = [(path.suffix, source) for path, text in apt_sources() if (source := source_of(text, name, SUITE))]
    if not found:
        raise FetchError(f"no apt source names {name}, so the mirror is unknown")
    suffix, source = found[0]
    for sub in ("parts", "lists/partial", "cache/archives/partial"):
        (folder / sub).mkdir(parents=True)
    (folder / "parts" / f"unity{suffix}").write_text(source)
    apt = ["apt-get", "-qq", "-o", "Dir::Etc::SourceList=/dev/null", "-o", f"Dir::Etc::SourceParts={folder}/parts",
           "-o", f"Dir::State::Lists={folder}/lists", "-o", f"Dir::Cache={folder}/cache",
           "-o", "Acquire::Languages=none", "-o", "APT::Update::Error-Mode=any"]  # or an update that fetched nothing would pass for one that did
    apt += give_to_sandbox(folder)
    for command in (["update"], ["source", "--download-only", "--tar-only", PACKAGE]):
        done = subprocess.run(apt + command, cwd=folder, capture_output=True, text=True)
        if done.returncode != 0:
            raise FetchError(f"apt-get {' '.join(command)} failed with the source\n{source}{done.stdout}{done.stderr}")
    archives = sorted(folder.glob(f"{PACKAGE}_*.tar.*"))
    if len(archives) != 1:
        raise FetchError(f"apt-get source {PACKAGE} left {len(archives)} archives instead of one")
    return archives[0]


def vendor(archive, folder):
    """Checks the archive and puts the files that a test needs into `folder`, all of them or none."""
    digest = hashlib.sha256(archive.read_bytes()).hexdigest()
    if digest != ARCHIVE_SHA256:
        raise FetchError(f"{archive.name} has SHA-256 {digest}, expected {ARCHIVE_SHA256}")
    new = pathlib.Path(tempfile.mkdtemp(prefix="unity.", dir=folder.parent))
    try:
        with tarfile.open(archive) as tar:
            for member in tar:
                inside = member.name.partition("/")[2]
                if inside in FILES:
                    (new / FILES[inside]).write_bytes(tar.extractfile(member).read())
        missing = [name for name in FILES.values() if not (new / name).is_file()]
        if missing:
            raise FetchError(f"{archive.name} lacks {', '.join(missing)}")
        (new / STAMP).write_text(ARCHIVE_SHA256 + "\n")
        new.chmod(0o755)
        shutil.rmtree(folder, ignore_errors=True)
        new.rename(folder)
    finally:
        shutil.rmtree(new, ignore_errors=True)


def is_complete(folder):
    stamp = folder / STAMP
    return (stamp.is_file() and stamp.read_text().strip() == ARCHIVE_SHA256
            and all((folder / name).is_file() for name in FILES.values()))


def main(args):
    if len(args) > 1 or args[:1] in (["-h"], ["--help"]):
        print(__doc__.strip())
        return 0 if len(args) == 1 else 64
    folder = pathlib.Path(args[0]) if args else pathlib.Path(__file__).parent / "unity"
    if is_complete(folder):
        return 0
    folder.parent.mkdir(parents=True, exist_ok=True)
    try:
        with tempfile.TemporaryDirectory(prefix="ssv-unity.") as scratch:
            vendor(download(pathlib.Path(scratch)), folder)
    except (FetchError, OSError, subprocess.CalledProcessError) as error:
        print(f"{pathlib.Path(__file__).name}: {error}\n"
              "Without it the tests cannot be built. Unpack Unity 2.5 yourself and configure with -DSSV_UNITY_DIR=FOLDER\n"
              "(the folder that holds unity.c), or build without tests: -DSSV_BUILD_TESTS=OFF.", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
