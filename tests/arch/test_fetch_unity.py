"""The Unity fetcher keeps to the machine's own mirror, in whatever format that is written."""
import os
import pathlib
import shutil
import sys
import tempfile
import unittest
import unittest.mock

from core import ROOT

sys.path.insert(0, str(ROOT / "tests/support"))
import fetch_unity  # noqa: E402

STANZAS = """# the mirror
Types: deb deb-src
URIs: http://mirror.example/debian
Suites: bookworm bookworm-updates
Components: main contrib
Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg

Types: deb
URIs: http://mirror.example/security
Suites: bookworm-security
Components: main
"""


class SourceOf(unittest.TestCase):
    def test_a_stanza_keeps_its_mirror_and_its_key(self):
        self.assertEqual(fetch_unity.source_of(STANZAS, "bookworm", "trixie").splitlines(), [
            "Types: deb-src",
            "URIs: http://mirror.example/debian",
            "Suites: trixie",
            "Components: main",
            "Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg",
        ])

    def test_a_line_keeps_its_mirror_and_its_options(self):
        text = ("# deb http://old.example bookworm main\n"
                "deb [signed-by=/k.gpg trusted=yes] http://m.example/debian bookworm main\n")
        self.assertEqual(fetch_unity.source_of(text, "bookworm", "trixie"),
                         "deb-src [signed-by=/k.gpg trusted=yes] http://m.example/debian trixie main\n")

    def test_a_key_written_out_in_the_stanza_survives(self):
        text = ("Types: deb\nURIs: http://m.example\nSuites: trixie\nComponents: main\n"
                "Signed-By:\n -----BEGIN KEY-----\n .\n abc\n")
        self.assertIn("Signed-By: \n -----BEGIN KEY-----\n .\n abc\n", fetch_unity.source_of(text, "trixie", "trixie"))

    def test_disabled_stanzas_other_suites_and_cdroms_do_not_count(self):
        for text in ("Enabled: no\n" + STANZAS.partition("\n")[2].partition("\n\n")[0], "deb http://m.example sid main\n",
                     "deb cdrom:[Debian]/ bookworm main\n", "deb http://m.example bookworm-updates main\n", ""):
            with self.subTest(text=text):
                self.assertIsNone(fetch_unity.source_of(text, "bookworm", "trixie"))


class Vendor(unittest.TestCase):
    def test_an_archive_with_another_checksum_leaves_no_folder(self):
        with tempfile.TemporaryDirectory() as scratch:
            archive = pathlib.Path(scratch) / "cmock.tar.xz"
            archive.write_bytes(b"not the archive")
            with self.assertRaisesRegex(fetch_unity.FetchError, "SHA-256"):
                fetch_unity.vendor(archive, pathlib.Path(scratch) / "unity")
            self.assertEqual([path.name for path in pathlib.Path(scratch).iterdir()], ["cmock.tar.xz"])


FAKE_APT = """#!/bin/sh
echo "$*" >>"{folder}/options"
[ "$1" = shell ] && {apt_config} "$@"
case "$*" in *source*) touch unity_1.tar.gz ;; esac
exit 0
"""


class Download(unittest.TestCase):
    def test_apt_keeps_its_sandbox_and_its_user_can_write_where_it_fetches(self):
        apt_config = shutil.which("apt-config")
        if apt_config is None:
            self.skipTest("no apt here")
        with tempfile.TemporaryDirectory() as scratch, tempfile.TemporaryDirectory() as target:
            for program in ("apt-get", "apt-config"):
                path = pathlib.Path(scratch) / program
                path.write_text(FAKE_APT.format(folder=scratch, apt_config=apt_config))
                path.chmod(0o755)
            stanza = "deb [trusted=yes] http://m.example/debian bookworm main\n"
            with unittest.mock.patch.dict(os.environ, PATH=f"{scratch}:{os.environ['PATH']}"), \
                 unittest.mock.patch.multiple(fetch_unity, codename=lambda: "bookworm",
                                              apt_sources=lambda: [(pathlib.Path("sources.list"), stanza)], PACKAGE="unity"):
                fetch_unity.download(pathlib.Path(target))
            kept = "Sandbox::User=" not in (pathlib.Path(scratch) / "options").read_text()
            try:
                others = os.geteuid() != 0 or "4294967295" in pathlib.Path("/proc/self/uid_map").read_text()
            except OSError:
                others = True
            self.assertEqual(kept, others)  # in a namespace whose one user is root there is no sandbox to be had
            if kept and os.geteuid() == 0:
                owners = {path.owner() for path in pathlib.Path(target).glob("**/") if path.is_dir()}
                self.assertEqual(owners, {"_apt"})


if __name__ == "__main__":
    unittest.main()
