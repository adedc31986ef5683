"""Replace libraries that only display something with stand-ins, because nothing is displayed while qdot grades.

Jupyter's own libraries (IPython, ipywidgets) are always replaced, because they need a front end and there is none. The
others are replaced only if they are not installed. Any operation on a stand-in does nothing and returns the stand-in.
Libraries that compute, such as SciPy, have no stand-in, because formulas made with one would be wrong.
"""

import sys
import types
from collections.abc import Callable, Iterator, Sequence
from importlib.machinery import ModuleSpec
from typing import Any

import numpy

JUPYTER_LIBRARIES = ("IPython", "ipywidgets", "ipympl")
DISPLAY_LIBRARIES = (
    "matplotlib", "mpl_toolkits", "plotly", "seaborn", "bokeh", "altair", "k3d", "pythreejs", "vpython", "graphviz",
    "google.colab",
)  # fmt: skip

STAR_IMPORT_NAMES = {
    "IPython.display": """Audio Code DisplayHandle HTML IFrame Image JSON Javascript Latex Markdown Math Pretty SVG
        Video YouTubeVideo clear_output display display_html display_latex display_markdown""",
    "matplotlib.pyplot": """annotate arrow axes axhline axis axvline bar clf close contour contourf figure fill gca gcf
        grid hist imshow legend pause plot quiver savefig scatter show subplot subplots suptitle text tight_layout title
        xlabel xlim ylabel ylim""",
}  # fmt: skip
"""The names that `from … import *` imports from a stand-in."""


def _find_attribute(_holder: object, name: str) -> Any:
    if name.startswith("__") and name.endswith("__"):
        raise AttributeError(name)
    return _return_limits if name in LIMIT_FUNCTIONS else STAND_IN


class _StandInMeta(type):
    """The metaclass of stand-ins: a stand-in for a class also has every attribute."""

    __getattr__ = _find_attribute


class StandIn(metaclass=_StandInMeta):
    """A figure, a widget, or a function that displays something."""

    __getattr__ = _find_attribute

    def __init__(self, *_args: Any, **_options: Any) -> None:
        """Accept any arguments."""

    def __setattr__(self, name: str, value: object) -> None:
        """Store nothing."""

    def __call__(self, *args: Any, **_options: Any) -> Any:
        """Return a decorated function unchanged, as with `@interact`; else return this stand-in."""
        return args[0] if len(args) == 1 and isinstance(args[0], types.FunctionType) else self

    def __setitem__(self, _key: object, _value: object) -> None:
        """Store nothing."""

    def __iter__(self) -> Iterator[Any]:
        return iter((self,))  # a single item, as in `line, = ax.plot(x, y)`

    def __exit__(self, *_error: object) -> None:
        """Do nothing."""

    def _return_itself(self, *_values: object) -> "StandIn":
        return self

    __enter__ = __getitem__ = _return_itself
    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = _return_itself
    __or__ = __ror__ = _return_itself


STAND_IN = StandIn()

LIMIT_FUNCTIONS = ("get_xlim", "get_ylim", "get_zlim", "xlim", "ylim")
"""Functions that return numbers, because a notebook may compute with them."""


def _return_limits(*_args: Any, **_options: Any) -> tuple[float, float]:
    return 0.0, 1.0


def _make_subplots(nrows: int = 1, ncols: int = 1, **_options: Any) -> tuple[Any, Any]:
    """Return stand-ins for a figure and its axes, in the shape that matplotlib returns."""
    axes = numpy.empty((nrows, ncols), object)
    axes[...] = STAND_IN
    return STAND_IN, axes.item() if axes.size == 1 else axes.squeeze()


class _StandInModule(types.ModuleType):
    def __getattr__(self, name: str) -> Any:
        is_class = name[:1].isupper()  # as in go.Figure
        return StandIn if is_class else _find_attribute(self, name)


class StandInFinder:
    """Finds the stand-in for a module by the beginning of the module's name, when a notebook imports the module.

    `attributes` maps some modules to attributes that are not stand-ins.
    """

    def __init__(self, prefixes: Sequence[str], attributes: dict[str, dict[str, Any]]) -> None:
        self._prefixes = {f"{prefix}." for prefix in prefixes}
        self._parent_prefixes = {f"{prefix.partition('.')[0]}." for prefix in prefixes}  # google of google.colab
        self._attributes = attributes

    def find_spec(self, name: str, _path: object = None, _target: object = None) -> ModuleSpec | None:
        """Return the specification of a module's stand-in, for Python's import system; None if there is no stand-in."""
        dotted_name = f"{name}."
        if dotted_name in self._parent_prefixes or any(map(dotted_name.startswith, self._prefixes)):
            return ModuleSpec(name, self, is_package=True)  # type: ignore[arg-type]
        return None

    def create_module(self, spec: ModuleSpec) -> types.ModuleType:
        """Return the stand-in for a module."""
        return _StandInModule(spec.name, "A stand-in for a library that displays something; it does nothing.")

    def exec_module(self, module: types.ModuleType) -> None:
        """Give the stand-in for a module a version, its real attributes, and the names for `from … import *`."""
        version = (9, 9, 0)  # high enough for every notebook that checks the version
        content = {"__version__": "9.9.0", "version_info": version, **self._attributes.get(module.__name__, {})}
        vars(module).update(content, __all__=STAR_IMPORT_NAMES.get(module.__name__, "").split())


def install(get_ipython: Callable[[], Any]) -> None:
    """Make imports find the stand-ins from now on."""
    sys.meta_path.insert(0, StandInFinder(JUPYTER_LIBRARIES, {"IPython": {"get_ipython": get_ipython}}))
    sys.meta_path.append(StandInFinder(DISPLAY_LIBRARIES, {"matplotlib.pyplot": {"subplots": _make_subplots}}))


def has_stand_in(name: str) -> bool:
    """Return whether there is a stand-in for a module, even if the module is installed (but can't be loaded)."""
    return any(f"{name}.".startswith(f"{library}.") for library in (*JUPYTER_LIBRARIES, *DISPLAY_LIBRARIES))
