"""Words and marks that the sources, comments and papers of the project must not have, each with what to write instead."""
import pathlib
import re
import tempfile
import unittest

from core import ROOT

# Mark: what to write instead. A mark counts in capitals only.
MARKS = {
    "TODO": "do it, or leave it out and say why in DESIGN",
    "FIXME": "repair it",
    "XXX": "say what is meant",
    "HACK": "say what it does and why",
    "TBD": "decide it, or leave it out",
}
# Word: what to write instead. A word counts in any case, with an s or not, and as a part of a name_like_this; to add one, add
# a line. It must be certain: no meaning that the project needs.
WORDS = {
    "auv": "vehicle",
    "basically": "nothing",
    "blacklist": "deny list",
    "dummy": "what it stands in for",
    "kludge": "what it does and why",
    "manoeuvre": "maneuver, the one spelling here",
    "obviously": "nothing, or the reason",
    "propeller": "thruster",
    "rov": "vehicle",
    "sanity": "what is checked, such as range or unit length",
    "stuff": "what it is",
    "thingy": "what it is",
    "whitelist": "allow list",
}
REFUSED = re.compile(rf"(?<![A-Za-z])(?:(?P<mark>{'|'.join(MARKS)})|(?P<word>(?i:{'|'.join(WORDS)})))s?(?![A-Za-z])")
# In the comments of C files: a series (1 + y + ...; 0, 1, ...), code in braces or marks, and a usage line (FILE...) may have it.
ELLIPSIS = r"(?<![+,-] )(?<!\{ )(?<![A-Z`])\.\.\.(?! \})"
FOLDERS = (".github", "firmware", "host", "lcmtypes", "sim", "tests")
NAMES = ("*.c", "*.h", "*.py", "*.sh", "*.java", "*.md", "*.txt", "*.lcm", "*.yaml", "*.yml", "*.cmake", "*.in", "*.ld")
NOT_OURS = ("tests/support/unity/", "tests/arch/test_words.py")


def comments_of(text):
    """C source with everything but its comments blanked; lines keep their numbers."""
    def keep(match):
        token = match[0]
        return token if token.startswith("/") else re.sub(r"[^\n]", " ", token)
    pattern = r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|[^/"\']+|.'
    return re.sub(pattern, lambda m: keep(m) if m[0][:2] in ("//", "/*") else re.sub(r"[^\n]", " ", m[0]), text, flags=re.S)


def breaches_of(path, text):
    """Each breach in one file, as a sentence."""
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        for match in REFUSED.finditer(line):
            instead = MARKS.get(match["mark"]) or WORDS[match["word"].lower()]
            found.append(f"{path}:{number}: '{match[0]}'; instead: {instead}")
        if "\N{HORIZONTAL ELLIPSIS}" in line:
            found.append(f"{path}:{number}: an ellipsis; instead: finish the sentence")
    if path.endswith((".c", ".h")):
        for number, line in enumerate(comments_of(text).splitlines(), 1):
            if re.search(ELLIPSIS, line):
                found.append(f"{path}:{number}: an ellipsis in a comment; instead: finish the sentence")
    return found


def breaches(root):
    """Every breach in the tree at root."""
    files = [file for folder in FOLDERS for name in NAMES for file in (root / folder).glob(f"**/{name}")]
    files += [file for name in NAMES for file in root.glob(name)]
    paths = {file.relative_to(root).as_posix(): file for file in sorted(files)}
    return [breach for path, file in paths.items() if not path.startswith(NOT_OURS)
            for breach in breaches_of(path, file.read_text(encoding="utf-8"))]


class Words(unittest.TestCase):
    def test_no_file_has_a_word_that_another_says_better(self):
        self.assertEqual(breaches(ROOT), [])

    def test_each_word_is_found_in_text_and_in_names(self):
        for word, instead in {**MARKS, **WORDS}.items():
            for line in (f"// A {word} here.", f"int {word}_of_it;", f"# {word}: later", f"Some {word}s."):
                with self.subTest(line=line):
                    self.assertEqual([b.partition("instead: ")[2] for b in breaches_of("sim/planted.c", line)], [instead])

    def test_a_planted_word_and_a_planted_ellipsis_are_told_with_file_and_line(self):
        with tempfile.TemporaryDirectory() as scratch:
            root = pathlib.Path(scratch)
            (root / "sim").mkdir()
            (root / "sim/planted.c").write_text("int a;\n// Then it goes on...\n")
            (root / "README.md").write_text("First.\n\nTODO: more\n")
            self.assertEqual([breach.partition(";")[0] for breach in breaches(root)],
                             ["README.md:3: 'TODO'", "sim/planted.c:2: an ellipsis in a comment"])

    def test_series_code_variadic_functions_and_words_that_hold_one_do_not_count(self):
        for line in ('char name[] = "%s.XXXXXX";', "void log_line(int level, const char* format, ...);", 'puts("more...");',
                     "/* 1 + y/2 + ... */", "/// if (ok) { ... } else { ... plan ... }", "// usage: program FILE...",
                     "int provide; // improve", "todo = list(edges)", "// 0, 1, ... of a field", "// `..._poll`"):
            with self.subTest(line=line):
                self.assertEqual(breaches_of("sim/planted.c", line), [])


if __name__ == "__main__":
    unittest.main()
