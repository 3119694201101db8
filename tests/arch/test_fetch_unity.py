"""The Unity fetcher keeps to the machine's own mirror, in whatever format that is written."""
import pathlib
import sys
import tempfile
import unittest

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


if __name__ == "__main__":
    unittest.main()
