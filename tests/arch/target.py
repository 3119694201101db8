"""Images for bare Cortex-M cores: builds them, runs them in the emulator, reads figures from them."""
import bisect
import dataclasses
import os
import pathlib
import re
import subprocess

from core import CORE, ROOT, SUPPORT, run

CORES = {"m3": "mps2-an385", "m4f": "mps2-an386", "m7": "mps2-an500"}  # and the machine that has it
PLANNED = ["name", "method", "status", "cost", "hash", "instructions", "stack_bytes"]  # a line of plan.c
WORK = pathlib.Path(os.environ["SSV_BUILD_DIR"]) / "target"  # kept, so that a second run compiles what changed
SHIPPED = pathlib.Path(os.environ["SSV_SHIPPED"])
MAVLINK = pathlib.Path(os.environ["SSV_MAVLINK_DIR"])


def build(cpu, scalar):
    """Cross compiles everything for a core, in the target's own build type; the folder with images and archive."""
    folder = WORK / f"{cpu}-{scalar}"
    run(["cmake", "--fresh", "-S", ROOT, "-B", folder, "-G", os.environ["SSV_GENERATOR"], "-DSSV_BUILD_HOST=OFF",
         f"--toolchain={ROOT}/firmware/target/arm-none-eabi.cmake", f"-DSSV_CPU={cpu}", f"-DSSV_REAL={scalar}",
         f"-DSSV_SHIPPED={SHIPPED}", f"-DSSV_MAVLINK_DIR={MAVLINK}"])
    run(["cmake", "--build", folder, "--parallel", "1"])
    return folder


def printed(command):
    """The lines that a program prints and the exit code that it ends with."""
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=300)
    return done.stdout.splitlines(), done.returncode


def emulate(cpu, image):
    """Likewise an image."""
    return printed(["qemu-system-arm", "-M", CORES[cpu], "-nographic", "-monitor", "none", "-serial", "none",
                    "-semihosting-config", "enable=on,target=native,arg=image", "-icount", "shift=5", "-kernel", image])


def run_here(name, scalar, folders=()):
    """Likewise tests/target/NAME.c, built for this machine, with these folders of firmware/ beside the core."""
    program = WORK / f"{name}-{scalar}"
    WORK.mkdir(parents=True, exist_ok=True)
    run([os.environ["CC"], "-std=c11", "-O2", "-ffp-contract=off", f"-DSSV_REAL_{scalar.upper()}",
         *(f"-I{ROOT}/{folder}" for folder in ("firmware/include", "firmware", "firmware/target")),
         f"-I{SUPPORT}", f"-I{SHIPPED.parent}", "-isystem", MAVLINK / "include",
         *sorted(CORE.glob("**/*.c")), *(file for folder in folders for file in sorted((ROOT / "firmware" / folder).glob("*.c"))),
         SUPPORT / "sample.c", ROOT / f"tests/target/{name}.c", ROOT / "tests/target/no_board.c",
         "-lm", "-o", program])
    return printed([program])


def planned(lines):
    """{(name, method): {field: text}} of what plan.c prints."""
    rows = [dict(zip(PLANNED, line.split(), strict=True)) for line in lines]
    return {(row["name"], row["method"]): row for row in rows}


def symbols(file):
    """{name: bytes} of the objects and functions in an image or archive."""
    return {name: int(size, 16) for size, name in
            re.findall(r"^[0-9a-f]+ ([0-9a-f]+) \w (\S+)$", run(["arm-none-eabi-nm", "-S", file]), re.M)}


def sections(archive):
    """Bytes of text (constants included), data and bss."""
    return [int(n) for n in run(["arm-none-eabi-size", "-t", archive]).splitlines()[-1].split()[:3]]


# ---- Stack --------------------------------------------------------------------------------------------------------------

def count_registers(words):
    """How many words a register list stands for: "r4-r7, lr" is 5, "d8-d9" is 4."""
    count = 0
    for word in words.split(","):
        first, _, last = word.strip().partition("-")
        number = 1 if not last else int(last[1:]) - int(first[1:]) + 1
        count += number * (2 if first.startswith("d") else 1)
    return count


def pushed_bytes(mnemonic, operands):
    """By how much an instruction lets the stack grow. A growth that is not a constant is an error."""
    base = mnemonic.split(".")[0]
    if base in ("push", "vpush") or (base in ("stmdb", "vstmdb") and operands.startswith("sp!")):
        return 4 * count_registers(operands[operands.index("{") + 1:operands.index("}")])
    written_back = re.search(r"\[sp, #-(\d+)\]!", operands)
    if written_back:
        return int(written_back[1])
    if base in ("sub", "subs", "subw") and operands.startswith("sp,"):
        return int(re.fullmatch(r"sp,(?: sp,)? #(\d+)", operands)[1])
    return 0


@dataclasses.dataclass
class Function:
    """As it stands in an image. The frame is the sum of all that its instructions push, so never too small."""
    name: str
    frame_bytes: int = 0
    callees: set = dataclasses.field(default_factory=set)  # addresses
    calls_through_pointer: bool = False


def disassembled(image):
    """{address: Function} of an image."""
    functions, jumps, here = {}, [], None
    for line in run(["arm-none-eabi-objdump", "-d", "--no-show-raw-insn", image]).splitlines():
        head = re.match(r"([0-9a-f]+) <(\S+)>:$", line)
        if head:
            here = int(head[1], 16)
            functions[here] = Function(head[2])
            continue
        code = re.match(r"\s*[0-9a-f]+:\t(\S+)\t([^;@]*)", line)
        if not code:
            continue
        mnemonic, operands = code[1], code[2].strip()
        functions[here].frame_bytes += pushed_bytes(mnemonic, operands)
        jump = re.search(r"\b([0-9a-f]+) <", operands)
        if mnemonic.startswith(("b", "cb")) and jump:
            jumps.append((here, int(jump[1], 16), mnemonic == "bl"))
        elif re.match(r"(blx?|bx) (?!lr)|(ldr|mov)\S* pc, (?!\[sp\]|lr)", f"{mnemonic} {operands}"):
            functions[here].calls_through_pointer = True
    starts = sorted(functions)
    for here, to, is_call in jumps:
        callee = starts[bisect.bisect_right(starts, to) - 1]
        if callee != here or is_call:
            functions[here].callees.add(callee)
    return functions


def compilers_frames(folder):
    """{function: [bytes of its frame as the compiler counts them, for each function of that name]}."""
    frames = {}
    for file in folder.rglob("*.c.su"):
        for name, size in re.findall(r"^\S+:(\S+)\t(\d+)\t", file.read_text(), re.M):
            frames.setdefault(name, []).append(int(size))
    return frames


def deepest(functions, name):
    """Bytes of stack that a call of the function can take, and the path there, by the call graph of an image."""
    known = {}

    def depth(address):
        if address not in known:
            function = functions[address]
            if function.calls_through_pointer:
                raise AssertionError(f"{function.name} calls through a pointer: no telling how deep the stack goes")
            known[address] = None
            below = [depth(callee) for callee in sorted(function.callees)]
            if None in below:
                raise AssertionError(f"{function.name} comes to call itself: no telling how deep the stack goes")
            bytes_below, path = max(below, default=(0, []))
            known[address] = function.frame_bytes + bytes_below, [f"{function.name} {function.frame_bytes}", *path]
        return known[address]

    return depth(next(address for address, function in functions.items() if function.name == name))
