"""What the architecture tests share: where the planner core is and how it is compiled by itself."""
import os
import pathlib
import re
import subprocess

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
CORE = ROOT / "firmware/planner"
SUPPORT = ROOT / "tests/support"


def core_flags():
    """What the build compiles the core with, whatever the compiler and its level."""
    return ["-std=c11", *os.environ["SSV_PLANNER_OPTIONS"].split(), f"-I{ROOT}/firmware/include", f"-I{ROOT}/firmware"]


def run(command, **options):
    """Runs a command; when it fails, its output is in the exception's text."""
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **options)
    if done.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, command))}\nended with {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def code_of(text):
    """C source without comments and with empty string and character literals; lines keep their numbers."""
    def blank(match):
        token = match[0]
        return token[0] * 2 if token[0] in "\"'" else " " + "\n" * token.count("\n")
    return re.sub(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', blank, text, flags=re.S)


def in_a_cycle(edges):
    """The nodes of a graph {node: {node}} from which a path leads back to themselves."""
    found = []
    for start in edges:
        todo, seen = list(edges[start]), set()
        while todo:
            node = todo.pop()
            if node not in seen:
                seen.add(node)
                todo += edges.get(node, ())
        if start in seen:
            found.append(start)
    return sorted(found)
