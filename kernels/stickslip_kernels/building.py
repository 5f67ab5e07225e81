"""Compiling a machine into one object, in a process that does nothing else.

Numba compiles a function together with all it calls: it links, optimises and emits what lies below each of 240
functions, once more at each. Only the outermost is called from outside. So the parts stay as Numba lowers them; they
are linked once, all but the outermost made local, and optimised as a whole.

What this relies on in Numba is not public, and all of it is here; tried with 0.61 and 0.68. Where it fails,
`exports.c_functions` does with public calls what takes three times as long.
"""

from __future__ import annotations

import gc
import os
import sys
from functools import cache, partial

# Intel's vector functions are not in every process that may load the object.
os.environ["NUMBA_DISABLE_INTEL_SVML"] = "1"

import llvmlite.binding as llvm
from llvmlite import ir
from numba.core import base, codegen, fastmathpass, postproc, transforms, types, utils
from numba.core import ir as numba_ir
from numba.core.compiler import DefaultPassBuilder
from numba.core.cpu_options import FastMathOptions
from numba.core.registry import cpu_target

from . import jit, objects
from . import layout as at
from .jit import WIDEST_VECTORS

# Passes of Numba for expressions of arrays, closures, what is inlined before LLVM sees it, and annotated listings.
_LEFT_OUT = {"NopythonRewrites", "InlineClosureLikes", "InlineInlinables", "InlineOverloads", "AnnotateTypes"}
_PLAIN = {str, int, float, bool, type(None), numba_ir.Loc}  # of an instruction, what are no variables
# What LLVM may call of the C library for an intrinsic of its own.
_CALLED_FOR_INTRINSICS = ("sin", "cos", "tan", "exp", "exp2", "log", "log2", "log10", "pow", "fmod")


class Part(codegen.JITCodeLibrary):
    """A function as it was lowered, into the one module of all; nothing is linked, optimised or emitted."""

    def __init__(self, maker, name):
        codegen.CodeLibrary.__init__(self, maker, name)

    def create_ir_module(self, name):
        """The module."""
        return self._codegen.whole

    def _nothing(self, *_):
        """It is there already; and it has no address, being called by others only."""
        return 0

    add_ir_module = add_linking_library = finalize = get_pointer_to_function = _nothing


class Parts(codegen.JITCPUCodegen):
    """Has Numba make parts."""

    _library_class = Part

    def __init__(self):
        super().__init__("parts")
        self.whole = self._create_empty_module("kernels")
        self.whole.data_layout = self._data_layout

    def set_env(self, name, environment):
        """Nothing of the interpreter is needed."""


def main(name: str, file: str) -> None:
    """Compile an object, and write its file to standard output; whatever else is printed goes to standard error."""
    gc.disable()  # an eighth of the time; this process is soon over
    with open(os.dup(1), "wb") as out:
        os.dup2(2, 1)
        out.write(objects.packed(file, build(name)))
    gc.freeze()  # nothing is looked through for what may go when the process ends: a tenth of the time


def build(name: str) -> objects.Object:
    """The object of this name (`objects.py`). From now on nothing else compiles here."""
    jit.compile_parts()
    sys.modules["scipy.linalg.cython_blas"] = None  # type: ignore[assignment]  # Numba loads it; no kernel calls it
    context = cpu_target.target_context
    context.refresh()
    context._internal_codegen = maker = Parts()
    context.create_cfunc_wrapper, context.post_lowering = partial(_make_door, context), lambda *_: None
    _remember()
    _leave_out_passes()
    _look_at_variables_once()
    from . import exports  # decorates the kernels, as parts

    made = exports.of_object(name)
    fastmathpass.rewrite_module(maker.whole, FastMathOptions(jit.FASTMATH))
    whole = llvm.parse_assembly(str(maker.whole))
    for symbol, function in made.items():
        whole.get_function(function.native_name).name = symbol
    _make_local(whole, set(made))
    _optimise(whole, maker._tm)
    return objects.Object(_symbols(whole), maker._tm.emit_object(whole))


def _make_door(context, library, function, environment, call_helper) -> None:
    """Numba's wrapper of a C function, without its words on exceptions: kernels never raise."""
    module, convention, kinds = context.codegen().whole, context.call_conv, function.argtypes
    door_type = ir.FunctionType(context.get_value_type(function.restype), [context.get_value_type(k) for k in kinds])
    inner = module.get_global(function.llvm_func_name)
    door = ir.Function(module, door_type, function.llvm_cfunc_wrapper_name)
    set.add(door.attributes, WIDEST_VECTORS)  # of the loops that are merged into it
    builder = ir.IRBuilder(door.append_basic_block())
    _, result = convention.call_function(builder, inner, function.restype, kinds, door.args)
    builder.ret(result)


def _optimise(module, target) -> None:
    """Loops over the lanes are not unrolled before they become vector code; shorter ones inside must be."""
    llvm.set_option("", f"--unroll-full-max-count={at.WIDTH - 1}")
    options = llvm.create_pipeline_tuning_options(speed_level=3)
    options.loop_vectorization, options.loop_interleaving, options.slp_vectorization = True, True, False
    builder = llvm.create_pass_builder(target, options)
    builder.getModulePassManager().run(module, builder)
    module.verify()


def _make_local(module, kept: set[str]) -> None:
    """Let nothing but the functions `kept` be seen from outside, so that whatever has been merged goes."""
    for thing in (*module.functions, *module.global_variables):
        if not thing.is_declaration:
            thing.linkage = "external" if thing.name in kept else "internal"
    for function in module.functions:
        if not function.is_declaration and any(f"{len(name)}{name}B" in function.name for name in jit.APART):
            function.add_function_attribute("noinline")


def _symbols(module) -> list[str]:
    """The functions a module expects to find, those in place of intrinsics included."""
    declared = [function.name for function in module.functions if function.is_declaration]
    called = {name for name in declared if not name.startswith("llvm.")}
    called |= {name.split(".")[1] for name in declared if name.startswith("llvm.")} & set(_CALLED_FOR_INTRINSICS)
    return sorted(called | {variable.name for variable in module.global_variables if variable.is_declaration})


def _remember() -> None:
    """Have Numba remember what functions and operators give for some types, signatures, and sizes of types.

    Of an operator it asks every implementation, those of strings and dates too, at each `+`: a quarter of the time.
    Functions that are chosen by type it would compile again for some.
    """
    resolve, known = types.BaseFunction.get_call_type, {}

    def get_call_type(self, context, args, kws):
        if kws:
            return resolve(self, context, args, kws)
        if (self, args) not in known:
            known[self, args] = resolve(self, context, args, kws)
        return known[self, args]

    call = types.Dispatcher.get_call_type

    def call_without_values(self, context, args, kws):  # one function for True and False, and for all numbers
        return call(self, context, tuple(map(types.unliteral, args)), kws)

    types.BaseFunction.get_call_type = get_call_type  # type: ignore[method-assign]
    types.Dispatcher.get_call_type = call_without_values  # type: ignore[method-assign]
    base.BaseContext.get_abi_sizeof = cache(base.BaseContext.get_abi_sizeof)  # type: ignore[method-assign]
    utils.pysignature = cache(utils.pysignature)  # type: ignore[attr-defined]


def _leave_out_passes() -> None:
    """Have Numba leave out passes that change nothing in kernels: a seventh of the time."""
    define = DefaultPassBuilder.define_nopython_pipeline

    def define_nopython_pipeline(state, name="nopython"):
        pipeline = define(state, name)
        pipeline.passes = [(one, text) for one, text in pipeline.passes if one.__name__ not in _LEFT_OUT]
        return pipeline

    setattr(DefaultPassBuilder, define.__name__, staticmethod(define_nopython_pipeline))


def _look_at_variables_once() -> None:
    """Have Numba find out where variables live for the pass that needs it, not after each: a fifth of the time."""
    run = postproc.PostProcessor.run

    def run_lazily(self, emit_dels=False, extend_lifetimes=False):
        whole = self.func_ir
        if emit_dels or whole.is_generator:
            run(self, emit_dels, extend_lifetimes)
            return
        whole.blocks = transforms.canonicalize_cfg(whole.blocks)
        whole.variable_lifetime, whole.generator_info = postproc.VariableLifetime(whole.blocks), None

    def variables(self, value):
        if isinstance(value, numba_ir.Var):
            return [value]
        if isinstance(value, numba_ir.Inst):
            return value.list_vars()
        if isinstance(value, dict):
            value = value.values()
        elif not isinstance(value, list | tuple):
            return []
        return [variable for part in value if type(part) not in _PLAIN for variable in variables(self, part)]

    postproc.PostProcessor.run = run_lazily  # type: ignore[method-assign]
    numba_ir.Inst._rec_list_vars = variables  # type: ignore[method-assign]
