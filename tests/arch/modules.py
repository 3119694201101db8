"""The table of the core's modules in firmware/DESIGN.md: what each is for, by the first sentence of its header, and which others
it includes. `python3 tests/arch/modules.py` writes it anew; arch.layers holds it to the sources."""
import re
import sys

from core import CORE, ROOT

DESIGN = ROOT / "firmware/DESIGN.md"
BEGIN, END = "<!-- modules: written by tests/arch/modules.py -->\n", "<!-- end of modules -->\n"
STOREYS = ("math", "model", "profile", "motion", "search", "")


def modules():
    """{module: [its files]}, headers first."""
    found = {}
    for file in sorted(CORE.glob("**/*.[ch]"), key=lambda file: file.suffix, reverse=True):
        found.setdefault(file.relative_to(CORE).with_suffix("").as_posix(), []).append(file)
    return found


def purpose(files):
    """The first sentence of the first file that begins with one."""
    for file in files:
        comment = re.match(r"((?://[^\n]*\n)+)", file.read_text())
        if comment:
            text = " ".join(line.lstrip("/ ") for line in comment[1].splitlines())
            return re.match(r".*?(?<!Eq)(?<!Eqs)[.?](?=\s|$)", text + ".")[0].replace("|", "\\|").rstrip(".")
    return ""


def includes(name, files):
    names = {included for file in files
             for included in re.findall(r'#include "planner/([\w/]+)\.\w+"', file.read_text())} - {name}
    return sorted(names)


def table():
    found = modules()
    order = sorted(found, key=lambda name: (STOREYS.index(name.rpartition("/")[0]), name))
    rows = [f"| `{name}` | {purpose(found[name])} | {', '.join(includes(name, found[name])) or '-'} |" for name in order]
    return "\n".join(["| module | what it is for | includes |", "|---|---|---|", *rows]) + "\n"


def written():
    """The table as DESIGN.md has it."""
    return DESIGN.read_text().partition(BEGIN)[2].partition(END)[0]


if __name__ == "__main__":
    head, _, rest = DESIGN.read_text().partition(BEGIN)
    if not rest:
        sys.exit(f"{DESIGN}: no line {BEGIN!r}")
    DESIGN.write_text(head + BEGIN + table() + END + rest.partition(END)[2])
