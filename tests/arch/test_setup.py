"""The set-up script tells what it does, and what is to be done where it cannot go on."""
import os
import pathlib
import stat
import subprocess
import sys
import tempfile
import unittest

from core import ROOT

sys.path.insert(0, str(ROOT / "tests/support"))
import fetch_unity  # noqa: E402

UPDATE_WITHOUT_NETWORK = """#!/bin/sh
case "$*" in
*update) echo "W: Failed to fetch http://m.example/InRelease  Temporary failure resolving 'm.example'" ;;
*) echo "E: Unable to locate package gcc"; exit 100 ;;
esac
"""


class Setup(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)
        self.build = self.folder / "build"
        self.build.mkdir()

    def run_bash(self, script):
        """Runs lines after host/setup.sh with another build folder, and programs of self.folder first in PATH."""
        lines = f'set -euo pipefail\nsource "{ROOT}/host/setup.sh"\nSSV_BUILD="{self.build}"\n{script}'
        return subprocess.run(["bash", "-c", lines], capture_output=True, text=True,
                              env={**os.environ, "PATH": f"{self.folder}:{os.environ['PATH']}"})

    def test_in_a_pipe_each_step_is_a_line_and_what_it_prints_is_not_shown(self):
        done = self.run_bash('_ssv_step "Counting" echo one two\n_ssv_step "Resting" true')
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", "Counting ...\nResting ...\n"))

    def test_a_step_that_fails_shows_what_it_printed(self):
        done = self.run_bash('_ssv_step "Counting" sh -c "echo one two; exit 3"\necho after')
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertIn("one two\n\nFailed: Counting.", done.stderr)
        self.assertNotIn("network", done.stderr)

    def test_a_failed_install_after_lists_that_could_not_be_read_is_told_as_a_missing_network(self):
        for name, text in (("apt-get", UPDATE_WITHOUT_NETWORK), ("sudo", '#!/bin/sh\n[ "$1" = -n ] && shift\nexec "$@"\n')):
            (self.folder / name).write_text(text)
            (self.folder / name).chmod(stat.S_IRWXU)
        done = self.run_bash('_ssv_missing_packages() { echo "gcc "; }\n_ssv_install_packages demo')
        if "not Debian 12 or 13" in done.stderr:
            self.skipTest("packages are installed on Debian alone")
        self.assertEqual(done.returncode, 1)
        self.assertIn("Unable to locate package gcc", done.stderr)
        self.assertIn("The network is missing", done.stderr)

    def test_the_fetcher_of_unity_fails_with_the_network_s_own_message_where_there_is_none(self):
        nowhere = "deb [trusted=yes] http://127.0.0.1:9/debian bookworm main\n"
        fetch_unity.apt_sources, kept = lambda: [(pathlib.Path("sources.list"), nowhere)], fetch_unity.apt_sources
        fetch_unity.codename, kept_name = lambda: "bookworm", fetch_unity.codename
        try:
            with self.assertRaisesRegex(fetch_unity.FetchError, "(?s)apt-get update failed.*(Could not connect|Cannot initiate|unreachable)"):
                fetch_unity.download(self.folder)
        finally:
            fetch_unity.apt_sources, fetch_unity.codename = kept, kept_name

    def test_a_build_folder_of_a_checkout_that_has_moved_is_named_with_what_to_remove(self):
        (self.build / "CMakeCache.txt").write_text("CMAKE_HOME_DIRECTORY:INTERNAL=/old/place\n")
        done = self.run_bash("ssv_setup demo")
        self.assertEqual(done.returncode, 1)
        self.assertIn("/old/place", done.stderr)
        self.assertIn(f"rm -rf {self.build}", done.stderr)

    def test_a_build_folder_of_this_checkout_by_another_path_is_no_stranger(self):
        (self.folder / "link").symlink_to(ROOT)
        (self.build / "CMakeCache.txt").write_text(f"CMAKE_HOME_DIRECTORY:INTERNAL={self.folder}/link\n")
        self.assertEqual(self.run_bash("_ssv_refuse_moved_checkout").returncode, 0)

    def test_options_that_exclude_one_another_are_wrong_usage(self):
        done = subprocess.run(["bash", ROOT / "tests/run.sh", "--quick", "--coverage"], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout), (64, ""))

    def test_help_names_each_option_and_exit_code(self):
        done = subprocess.run(["bash", ROOT / "tests/run.sh", "--help"], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        for word in ("--quick", "--coverage", "--long", "Examples:", "Exit codes: 0", "8 some failed", "64 wrong usage"):
            self.assertIn(word, done.stdout)


if __name__ == "__main__":
    unittest.main()
