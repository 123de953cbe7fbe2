"""Compiled code as a file of the kernel cache holds it, and its way back into numba."""

from typing import Any

from llvmlite import binding
from numba.core import caching, codegen, compiler
from numba.core.environment import Environment, lookup_environment


class _StoredLibrary(codegen.JITCodeLibrary):
    """The code of a stored kernel, whose form for inlining is read only when another kernel is compiled with it.

    Numba's own reads it at once, and looks at each of its symbols: most of the time that it takes to load a kernel.
    """

    _shared_module: Any                     # the form for inlining, from when it is read

    def __init__(self, generator: Any, name: str, code: bytes, bitcode: bytes, entries: tuple[str, ...]):
        """entries: names under which other code may call it, of which `code` has some."""
        super().__init__(generator, name)
        self._bitcode = bitcode
        self.enable_object_caching()
        self._set_compiled_object(code)
        self._finalize_final_module()
        generator._engine._defined_symbols.update(entry for entry in entries if entry.encode() in code)

    def _get_module_for_linking(self) -> Any:
        if self._shared_module is None:
            self._shared_module = binding.parse_bitcode(self._bitcode)
            self._codegen._engine._load_defined_symbols(self._shared_module)
        return self._shared_module


class CodeReducer(caching.CompileResultCacheImpl):
    """Numba's conversion of compiled code to and from what can be pickled, without its search for a folder."""

    def __init__(self) -> None:
        """Numba's own needs the folder of the source."""

    def rebuild(self, target_context: Any, payload: tuple[Any, ...]) -> Any:
        """The compiled kernel of what `reduce` made of it."""
        (name, _, codes), described, environment, signature, in_objects, lifted, typed, begin, constants = payload
        for function in begin:
            function()
        generator = target_context.codegen()
        entries = (described.llvm_func_name, described.llvm_cpython_wrapper_name,
                   described.llvm_cfunc_wrapper_name)
        library = _StoredLibrary(generator, name, *codes, entries)      # type: ignore[call-arg]
        environments = tuple(_environment(*each) for each in constants)   # kept by the result: code has addresses only
        result = compiler.CompileResult(
            target_context=target_context, typing_context=target_context.typing_context, library=library,
            environment=environment, entry_point=target_context.get_executable(library, described, environment),
            fndesc=described, type_annotation=typed, signature=signature, objectmode=in_objects, lifted=lifted,
            typing_error=None, call_helper=None, metadata=None, reload_init=begin, referenced_envs=environments)
        for each in environments:
            generator.set_env(each.env_name, each)
        return result

    def reduce(self, cres: Any) -> tuple[Any, ...]:
        """What can be pickled, without the source that numba annotates with types: half of a file, and never read."""
        *parts, environments = super().reduce(cres._replace(type_annotation=""))
        return *parts, tuple((each.globals["__name__"], each.consts, each.env_name) for each in environments)

    def check_cachable(self, cres: Any) -> bool:
        """Whether the code refers to no address of this process."""
        return not cres.library.has_dynamic_globals and all(lifted.can_cache for lifted in cres.lifted)


def _environment(module: str, constants: list[Any], name: str) -> Environment:
    """The constants of a function that compiled code calls.

    Numba's own has the names of its module as well, which only interpreted code would look up, and so imports the
    module: that of sums of arrays alone takes 50 ms.
    """
    environment = lookup_environment(name)
    if environment is None:
        environment = Environment({"__name__": module})
        environment.consts[:] = constants
        environment.env_name = name
        Environment._memo[name] = environment
    return environment
