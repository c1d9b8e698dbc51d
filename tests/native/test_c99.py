"""Translation of LLVM assembly to C: each instruction against LLVM's own machine code, bit for bit."""

import ctypes
import itertools
import math
import platform
import shutil
import struct

import pytest
from command_line import run_program

from fmi_export.building.native.c99.translation import HEADER, to_c
from fmi_export.building.native.sources import FOLDER
from tests.support.messages import raises_naming

pytest.importorskip("llvmlite")
pytestmark = pytest.mark.skipif(not shutil.which("gcc"), reason="needs gcc")

STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O2", "-fPIC", "-shared")
INTEGERS = (0, 1, -1, 7, -100, 255, 2**31, -(2**63), 2**63 - 1)
REALS = ((0.0, -0.0), (1.5, -2.25), (1e300, 1e-300), (math.inf, -math.inf), (math.nan, 3.0), (-7.75, 2.5), (1e19, 0.3))
PARAMETERS = "i64 %a, i64 %b, double %x, double %y"


def after(*lines, of="i64"):
    """The body of a function that returns the last value, `%r`."""
    return of, "\n".join([*lines, f"ret {of} %r"])


def narrow(opcode, width, second="%t"):
    """An instruction on integers of fewer bits."""
    cut = (f"%s = trunc i64 %a to i{width}", f"%t = trunc i64 %b to i{width}")
    return after(*cut, f"%q = {opcode} i{width} %s, {second}", f"%r = sext i{width} %q to i64")


SHIFTED = "%c = and i64 %b, 63"
DIVISORS = ("%h = ashr i64 %a, 1", "%c = or i64 %b, 1")  # no overflow, no zero
INTEGER = (
    {op: after(f"%r = {op} i64 %a, %b") for op in ("add", "sub", "mul", "and", "or", "xor")}
    | {op: after(SHIFTED, f"%r = {op} i64 %a, %c") for op in ("shl", "lshr", "ashr")}
    | {op: after(*DIVISORS, f"%r = {op} i64 %h, %c") for op in ("sdiv", "srem", "udiv", "urem")}
    | {f"{op}_i{w}": narrow(op, w) for op in ("add", "sub", "mul", "xor") for w in (1, 8, 16, 32)}
    | {f"{op}_i{w}": narrow(op, w, "3") for op in ("shl", "lshr", "ashr") for w in (8, 16, 32)}
    | {
        f"icmp_{order}_i{w}": after(
            *(f"%s = trunc i64 %a to i{w}", f"%t = trunc i64 %b to i{w}") if w < 64 else ("%s = freeze i64 %a",),
            f"%q = icmp {order} i{w} %s, {'%t' if w < 64 else '%b'}",
            "%r = zext i1 %q to i64",
        )
        for order in ("eq", "ne", "sgt", "sge", "slt", "sle", "ugt", "uge", "ult", "ule")
        for w in (1, 8, 64)
    }
    | {f: after(f"%r = call i64 @llvm.{f}.i64(i64 %a, i64 %b)") for f in ("smax", "smin", "umax", "umin")}
    | {f: after(f"%r = call i64 @llvm.{f}.i64(i64 %a, i1 false)") for f in ("abs", "ctlz", "cttz")}
    | {"ctpop": after("%r = call i64 @llvm.ctpop.i64(i64 %a)")}
    | {
        f"ctlz_i{w}": after(
            f"%s = trunc i64 %a to i{w}",
            f"%q = call i{w} @llvm.ctlz.i{w}(i{w} %s, i1 false)",
            f"%r = zext i{w} %q to i64",
        )
        for w in (8, 32)
    }
    | {f"zext_i{w}": after(f"%s = trunc i64 %a to i{w}", f"%r = zext i{w} %s to i64") for w in (1, 8, 16, 32)}
    | {f"sext_i{w}": after(f"%s = trunc i64 %a to i{w}", f"%r = sext i{w} %s to i64") for w in (1, 8, 16, 32)}
    | {"select": after("%s = trunc i64 %a to i1", "%r = select i1 %s, i64 %b, i64 -9223372036854775808")}
)

ORDERS = ("eq", "gt", "ge", "lt", "le", "ne")
FCMP = ("ord", "uno", *(kind + order for kind in "ou" for order in ORDERS))
ONE = ("fabs", "sqrt", "exp", "exp2", "sin", "cos", "log", "log2", "log10", "floor", "ceil", "trunc", "rint")
REAL = (
    {op: after(f"%r = {op} double %x, %y", of="double") for op in ("fadd", "fsub", "fmul", "fdiv", "frem")}
    | {"fneg": after("%r = fneg double %x", of="double")}
    | {f"fcmp_{p}": after(f"%q = fcmp {p} double %x, %y", "%r = zext i1 %q to i64") for p in FCMP}
    | {f: after(f"%r = call fast double @llvm.{f}.f64(double %x)", of="double") for f in ONE}
    | {f: after(f"%r = tail call double @{f}(double %x)", of="double") for f in ("round", "tanh", "expm1", "log1p")}
    | {f: after(f"%r = call double @llvm.{f}.f64(double %x, double %y)", of="double") for f in ("pow", "copysign")}
    | {"fma": after("%r = call double @llvm.fma.f64(double %x, double %y, double 0.1)", of="double")}
    | {"hypot": after("%r = call double @hypot(double %x, double %y)", of="double")}
    | {"sum_of_products": after("%p = fmul double %x, %y", "%r = fadd double %p, 0x3FB999999999999A", of="double")}
    | {
        "fptosi": after(
            "%u = call double @llvm.fabs.f64(double %x)",
            "%q = fcmp olt double %u, 1.0e18",
            "%s = fptosi double %x to i64",
            "%r = select i1 %q, i64 %s, i64 5",
        )
    }
    # Larger than an integer: LLVM leaves it open, the C code has what x86 has.
    | ({"fptosi_too_large": after("%r = fptosi double %x to i64")} if platform.machine() in ("x86_64", "AMD64") else {})
    | {
        "fptoui": after(
            "%q = fcmp oge double %x, 0.0",
            "%p = fcmp olt double %x, 1.8e+19",
            "%o = and i1 %q, %p",
            "%u = select i1 %o, double %x, double 9.9",
            "%r = fptoui double %u to i64",
        )
    }
    | {
        f"{op}_i{w}": after(f"%s = trunc i64 %a to i{w}", f"%r = {op} i{w} %s to double", of="double")
        for op in ("sitofp", "uitofp")
        for w in (1, 8, 32)
    }
    | {op: after(f"%r = {op} i64 %a to double", of="double") for op in ("sitofp", "uitofp")}
    | {
        "to_bits": after("%r = bitcast double %x to i64"),
        "from_bits": after("%r = bitcast i64 %a to double", of="double"),
    }
    | {
        f"constant_{k}": after(f"%r = select i1 true, double {text}, double %x", of="double")
        for k, text in enumerate(
            ("0x7FF0000000000000", "0xFFF0000000000000", "0x7FF8000000000123", "-0.0", "0x3FB999999999999A")
        )
    }
)

PAIR = "{ i8, double, i32 }"
FLOW = {
    "swap_in_a_loop": after(
        "entry:\nbr label %loop\nloop:\n%i = phi i64 [ 0, %entry ], [ %j, %loop ]",
        "%p = phi i64 [ %a, %entry ], [ %q, %loop ]\n%q = phi i64 [ %b, %entry ], [ %p, %loop ]",
        "%j = add nuw nsw i64 %i, 1\n%done = icmp eq i64 %j, 7\nbr i1 %done, label %out, label %loop, !prof !0\nout:",
        "%m = mul i64 %p, 3\n%r = sub i64 %m, %q",
    ),
    "old_value_after_a_loop": after(
        "entry:\n%z = and i64 %a, 255\nbr label %loop\nloop:\n%i = phi i64 [ %z, %entry ], [ %j, %loop ]",
        "%j = add i64 %i, 3\n%c = and i64 %j, 16\n%done = icmp ne i64 %c, 0",
        "br i1 %done, label %out, label %loop\nout:\n%r = mul i64 %i, %j",
    ),
    "switch": after(
        "entry:\n%c = and i64 %a, 3\nswitch i64 %c, label %other [\n  i64 0, label %none\n  i64 3, label %out\n]",
        "none:\nbr label %out\nother:\n%m = add i64 %b, 1\nbr label %out\nout:",
        "%r = phi i64 [ 11, %none ], [ %m, %other ], [ %b, %entry ]",
    ),
    "structure_in_memory": after(
        f"%s = alloca {PAIR}, align 8",
        f"%p = getelementptr inbounds {PAIR}, ptr %s, i64 0, i32 1",
        f"%q = getelementptr inbounds {PAIR}, ptr %s, i32 0, i32 2",
        "call void @llvm.memset.p0.i64(ptr align 8 %s, i8 1, i64 24, i1 false), !noalias !1",
        "store double %x, ptr %p, align 8\n%t = trunc i64 %a to i32\nstore i32 %t, ptr %q, align 4",
        f"%o = load {PAIR}, ptr %s, align 8",
        f"%f = extractvalue {PAIR} %o, 0\n%g = extractvalue {PAIR} %o, 2\n%h = load double, ptr %p",
        "%k = zext i8 %f to i64\n%l = zext i32 %g to i64\n%n = bitcast double %h to i64",
        "%e = add i64 %k, %l\n%r = add i64 %e, %n",
    ),
    "structure_as_a_value": after(
        f"entry:\n%c = icmp sgt i64 %a, %b\n%s = insertvalue {PAIR} {{ i8 3, double poison, i32 undef }}, double %x, 1",
        f"%m = insertvalue {PAIR} %s, i32 9, 2\nbr i1 %c, label %left, label %right",
        f"left:\n%t = insertvalue {PAIR} %m, double %y, 1\nbr label %right",
        f"right:\n%u = phi {PAIR} [ %t, %left ], [ %m, %entry ]\n%v = select i1 %c, {PAIR} %u, {PAIR} %m",
        f"%w = extractvalue {PAIR} %v, 1\n%z = extractvalue {PAIR} %v, 2\n%k = sitofp i32 %z to double",
        "%r = fadd double %w, %k",
        of="double",
    ),
    "addresses": after(
        "%s = alloca [4 x [3 x i64]], align 16\n%c = and i64 %a, 1\n%t = trunc i64 %c to i32",
        "call void @llvm.memset.p0.i64(ptr %s, i8 0, i64 96, i1 false)",
        "%p = getelementptr [4 x [3 x i64]], ptr %s, i64 0, i64 2, i32 %t\nstore i64 %b, ptr %p, align 8",
        "%q = getelementptr i64, ptr %p, i64 1\n%o = getelementptr i8, ptr %q, i64 -8\n%l = load i64, ptr %o, align 8",
        "%d = ptrtoint ptr %q to i64\n%e = ptrtoint ptr %s to i64\n%f = sub i64 %d, %e\n%r = mul i64 %l, %f",
    ),
    "copies": after(
        "%s = alloca [3 x i64]\n%t = alloca [3 x i64]\nstore i64 %a, ptr %s, align 1",
        "%p = getelementptr i8, ptr %s, i64 8\nstore i64 %b, ptr %p, align 1",
        "call void @llvm.memmove.p0.p0.i64(ptr %p, ptr %s, i64 16, i1 false)",
        "call void @llvm.memcpy.p0.p0.i64(ptr %t, ptr %s, i64 24, i1 false)",
        "%q = getelementptr i8, ptr %t, i64 16\n%u = load i64, ptr %q\n%v = load i64, ptr %t\n%r = sub i64 %u, %v",
    ),
    "bits_and_addresses_in_memory": after(
        "%s = alloca i1\n%t = alloca ptr\n%c = trunc i64 %a to i1\nstore i1 %c, ptr %s, align 1\nstore ptr %s, ptr %t",
        "%p = load ptr, ptr %t\n%d = load i1, ptr %p, align 1\n%e = icmp eq ptr %p, null\n%f = or i1 %d, %e",
        "%r = zext i1 %f to i64",
    ),
    "table": after(
        "%c = and i64 %a, 3\n%p = getelementptr [4 x double], ptr @table, i64 0, i64 %c",
        "%r = load double, ptr %p, align 8",
        of="double",
    ),
    "bytes": after(
        "%c = and i64 %a, 3\n%p = getelementptr i8, ptr @bytes, i64 %c\n%q = load i8, ptr %p\n%r = zext i8 %q to i64"
    ),
    "call": after(
        "%s = alloca double, align 8\n%q = call fastcc i32 @inner(ptr noalias nonnull %s, double %x, i64 %b) #0",
        "%d = load double, ptr %s, align 8\n%k = sitofp i32 %q to double\n%r = fadd double %d, %k",
        of="double",
    ),
    "nothing": after("call void @llvm.assume(i1 true)\n%r = call i64 @llvm.expect.i64(i64 %a, i64 0)"),
}

CASES = INTEGER | REAL | FLOW
BEFORE = """
@table = internal constant [4 x double] [double 0.1, double -3.0, double 0x3FB5555555555555, double 1.0e+22], align 8
@bytes = internal constant [4 x i8] c"a\\00\\FFz", align 1
@zeros = internal constant { ptr, i32 } zeroinitializer

define internal fastcc range(i32 0, 9) i32 @inner(ptr noalias captures(none) %place, double %x, i64 %n) #0 {
  store double %x, ptr %place, align 8
  %c = icmp slt i64 %n, 0
  br i1 %c, label %one, label %other
one:
  ret i32 1
other:
  %k = trunc i64 %n to i32
  %l = urem i32 %k, 9
  ret i32 %l
}
"""
AFTER = """
attributes #0 = { nounwind }
!0 = !{!"branch_weights", i32 1, i32 99}
!1 = !{!2}
!2 = distinct !{!2, !3}
!3 = distinct !{!3}
"""
C_TYPES = {"i64": ctypes.c_int64, "double": ctypes.c_double}


def declarations(text):
    """Declare what is called and not defined."""
    result = {}
    for line in text.splitlines():
        if " call " in f" {line}" and "@inner" not in line:
            head, arguments = line.split("(", 1)
            kinds = [a.split()[0] for a in arguments.rsplit(")", 1)[0].split(", ")]
            result[head.split("@")[1]] = f"declare {head.split()[-2]} @{head.split('@')[1]}({', '.join(kinds)})"
    return "\n".join(result.values())


@pytest.fixture(scope="module")
def module():
    """All cases, as LLVM reads and writes them."""
    import llvmlite.binding as llvm

    functions = [f"define {of} @case_{name}({PARAMETERS}) {{\n{body}\n}}" for name, (of, body) in CASES.items()]
    text = "\n\n".join(functions)
    parsed = llvm.parse_assembly("\n".join([BEFORE, text, declarations(text), AFTER]))
    parsed.verify()
    return parsed


@pytest.fixture(scope="module")
def machine_code(module):
    """LLVM's own code of all cases, for as long as the fixture lives."""
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.create_mcjit_compiler(module, llvm.Target.from_default_triple().create_target_machine(opt=0))


def compiled(text, folder, *options):
    (folder / "cases.c").write_text(text)
    (folder / HEADER).write_text((FOLDER / "c99" / HEADER).read_text())
    run_program("gcc", *STRICT, *options, folder / "cases.c", "-o", folder / "cases.so", "-lm")
    return ctypes.CDLL(str(folder / "cases.so"))


@pytest.fixture(scope="module")
def translated(module, tmp_path_factory):
    """The same in C, compiled without a warning."""
    return compiled(to_c(str(module)), tmp_path_factory.mktemp("c99"))


def bits(value):
    """A result as an integer; every number that is none is one and the same."""
    if isinstance(value, int):
        return value
    return "nan" if math.isnan(value) else struct.unpack("<q", struct.pack("<d", value))[0]


@pytest.mark.parametrize("name", CASES)
def test_translated_code_gives_the_bits_of_machine_code(machine_code, translated, name):
    of = C_TYPES[CASES[name][0]]
    kinds = (ctypes.c_int64, ctypes.c_int64, ctypes.c_double, ctypes.c_double)
    theirs = ctypes.CFUNCTYPE(of, *kinds)(machine_code.get_function_address(f"case_{name}"))
    ours = getattr(translated, f"case_{name}")
    ours.restype, ours.argtypes = of, kinds
    if name in INTEGER:
        values = [(a, b, 0.0, 0.0) for a, b in itertools.product(INTEGERS, repeat=2)]
    else:
        values = [
            (a, b, x, y) for a, b in ((5, -3), (-6, 300)) for item, two in REALS for x, y in ((item, two), (two, item))
        ]
    different = [item for item in values if bits(ours(*item)) != bits(theirs(*item))]
    assert different == []
    assert len({bits(ours(*item)) for item in values}) > (0 if "constant" in name else 1)


@pytest.mark.parametrize(
    ("line", "facts"),
    [
        ("%r = fadd <2 x double> zeroinitializer, zeroinitializer", ("'<'",)),
        ("%r = add i128 1, 2", ("'i128'",)),
        ("%r = atomicrmw add ptr null, i64 1 seq_cst", ("'atomicrmw'",)),
        ("%r = load volatile i64, ptr null", ("volatile",)),
        ("%r = alloca i64, i64 %a", ("number of elements",)),
        ("%r = call double @llvm.fmuladd.f64(double %x, double %y, double %x)", ("llvm.fmuladd.f64",)),
        ("call void @llvm.trap()", ("llvm.trap",)),
    ],
)
def test_llvm_code_without_counterpart_in_c_is_refused_with_its_line(line, facts):
    with raises_naming(ValueError, *facts) as refused:
        to_c(f"define i64 @f({PARAMETERS}) {{\n  {line}\n  ret i64 %r\n}}\n")
    assert line in str(refused.value)


def test_a_writable_global_variable_is_refused():
    with raises_naming(ValueError, "variable", "written"):
        to_c("@counter = internal global i64 0\n")
