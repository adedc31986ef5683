"""What stands for libraries that only show something: nothing is displayed where a notebook is graded.

Jupyter's own (IPython, ipywidgets) talk to a front end, of which there is none, and are always stood for; the others
only where they are not installed. Whatever is done with a stand-in gives the stand-in again, and does nothing. It is
for what is seen: a library that computes (SciPy) has none, for a formula made with it would be another one.
"""

import sys
import types
from collections.abc import Callable, Iterator, Sequence
from importlib.machinery import ModuleSpec
from typing import Any

import numpy

JUPYTER = ("IPython", "ipywidgets", "ipympl")
SHOWING = (
    "matplotlib", "mpl_toolkits", "plotly", "seaborn", "bokeh", "altair", "k3d", "pythreejs", "vpython", "graphviz",
    "google.colab",
)  # fmt: skip

STARRED = {
    "IPython.display": """Audio Code DisplayHandle HTML IFrame Image JSON Javascript Latex Markdown Math Pretty SVG
        Video YouTubeVideo clear_output display display_html display_latex display_markdown""",
    "matplotlib.pyplot": """annotate arrow axes axhline axis axvline bar clf close contour contourf figure fill gca gcf
        grid hist imshow legend pause plot quiver savefig scatter show subplot subplots suptitle text tight_layout title
        xlabel xlim ylabel ylim""",
}  # fmt: skip
"""What `from … import *` takes of a stand-in."""


class _Kind(type):
    """What stands for a class has whatever attribute is asked for, too."""

    def __getattr__(cls, name: str) -> Any:
        return _attribute(name)


class StandIn(metaclass=_Kind):
    """A figure, a widget, a function that shows something: whatever is done with it gives it again."""

    def __init__(self, *_args: Any, **_options: Any) -> None:
        """Take anything."""

    def __getattr__(self, name: str) -> Any:
        return _attribute(name)

    def __setattr__(self, name: str, value: object) -> None:
        """Keep nothing."""

    def __call__(self, *args: Any, **_options: Any) -> Any:
        """Give a function back that was decorated, as by `@interact`."""
        return args[0] if len(args) == 1 and isinstance(args[0], types.FunctionType) else self

    def __getitem__(self, _key: object) -> Any:
        return self

    def __setitem__(self, _key: object, _value: object) -> None:
        """Keep nothing."""

    def __iter__(self) -> Iterator[Any]:
        return iter((self,))  # one, as in `line, = ax.plot(x, y)`

    def __enter__(self) -> Any:
        return self

    def __exit__(self, *_error: object) -> None:
        """End nothing."""


def _itself(self: StandIn, *_others: object) -> StandIn:
    return self


for _operator in ("add", "sub", "mul", "truediv", "or"):
    setattr(StandIn, f"__{_operator}__", _itself)
    setattr(StandIn, f"__r{_operator}__", _itself)

NOTHING = StandIn()


def _limits(*_args: Any, **_options: Any) -> tuple[float, float]:
    return 0.0, 1.0


LIMITS = ("get_xlim", "get_ylim", "get_zlim", "xlim", "ylim")
"""What returns numbers, with which something may be computed."""


def _attribute(name: str) -> Any:
    if name.startswith("__") and name.endswith("__"):
        raise AttributeError(name)
    return _limits if name in LIMITS else NOTHING


def _subplots(nrows: int = 1, ncols: int = 1, **_options: Any) -> tuple[Any, Any]:
    """Return a figure and its axes in the shape in which matplotlib has them."""
    axes = numpy.empty((nrows, ncols), object)
    axes[...] = NOTHING
    return NOTHING, axes.item() if axes.size == 1 else axes.squeeze()


class _Module(types.ModuleType):
    def __getattr__(self, name: str) -> Any:
        return StandIn if name[:1].isupper() else _attribute(name)  # a class, as go.Figure, or a function


class Finder:
    """Finds stand-ins by the beginnings of modules' names; `contents` are names that modules really have."""

    def __init__(self, beginnings: Sequence[str], contents: dict[str, dict[str, Any]]) -> None:
        self._beginnings = {f"{beginning}." for beginning in beginnings}
        self._parents = {f"{beginning.partition('.')[0]}." for beginning in beginnings}
        self._contents = contents

    def find_spec(self, name: str, _path: object = None, _target: object = None) -> ModuleSpec | None:
        """Return how a stand-in is made, None for another module."""
        dotted = f"{name}."
        if dotted in self._parents or any(map(dotted.startswith, self._beginnings)):
            return ModuleSpec(name, self, is_package=True)  # type: ignore[arg-type]
        return None

    def create_module(self, spec: ModuleSpec) -> types.ModuleType:
        """Return the stand-in for a module."""
        return _Module(spec.name, "It stands for a library that shows something, and does nothing.")

    def exec_module(self, module: types.ModuleType) -> None:
        """Give a stand-in what its module is sure to be asked for."""
        content = {"__version__": "9.9.0", "version_info": (9, 9, 0), **self._contents.get(module.__name__, {})}
        vars(module).update(content, __all__=STARRED.get(module.__name__, "").split())


def install(get_ipython: Callable[[], Any]) -> None:
    """Have imports find stand-ins from now on."""
    sys.meta_path.insert(0, Finder(JUPYTER, {"IPython": {"get_ipython": get_ipython}}))
    sys.meta_path.append(Finder(SHOWING, {"matplotlib.pyplot": {"subplots": _subplots}}))


def stands_for(name: str) -> bool:
    """Tell whether there is a stand-in for a module, be it because that one is there and can't be loaded."""
    return any(f"{name}.".startswith(f"{known}.") for known in (*JUPYTER, *SHOWING))
