"""Models of vibration energy harvesters, by the embedded core that runs on a sensor node.

A scene is the path of a scene file, its text, or its tables as a dictionary; the path of a recording is then absolute.
``changes`` replaces keys of it, as ``--set`` of the command line does: ``changes={"load.resistance_ohm": 1e6}``. Options have
the names of the command line with underscores (:class:`Options`). All quantities are in SI units and have their unit in their
name.

Bad input raises ``ValueError``, an unknown keyword ``TypeError``, a run that cannot be stepped to its end ``RuntimeError``.
The interpreter lock is released while the engine runs. Ctrl-C ends the wait for a result at once; a sweep begins no further
run, and what runs already goes on unseen to its end.

A number that a result does not have is ``None`` in a dictionary, and not-a-number in an array of ``sweep``.
"""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import importlib.metadata
import json
import os
import pathlib
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future
from typing import TYPE_CHECKING, Any, TypedDict, TypeVar, Union

import numpy as np

try:
    from . import _native
except ImportError as error:
    raise ImportError(
        f"vibration_harvester: the native module cannot be loaded ({error}); build it for this Python, "
        f"{sys.version_info.major}.{sys.version_info.minor}, by `pip install ./host-bench/python` with Rust installed"
    ) from error

if TYPE_CHECKING:
    from numpy.typing import ArrayLike
    from typing_extensions import Unpack

__all__ = [
    "Map", "Picture", "budget", "fit", "needs", "optimise", "plot", "records", "resonance", "response_map", "run", "sweep",
    "tolerance", "validation",
]
__version__ = importlib.metadata.version("vibration-harvester")

Source = Union[str, "os.PathLike[str]", Mapping[str, Any]]
"""A scene: path, text (with a line break), or tables."""
Changes = Mapping[str, Any]
"""Values of keys such as ``load.resistance_ohm``: numbers, texts, truth values, lists, tables."""


class Options(TypedDict, total=False):
    """Options of every run, by the names of the command line."""

    method: str
    precision: str
    math: str
    accuracy: float
    tolerance: float
    step: float
    """In s."""
    long_step: float
    """In s."""


class FitOptions(Options, total=False):
    """Options of a fit."""

    loss: str
    starts: int
    iterations: int
    output: str | os.PathLike[str]
    picture: str | os.PathLike[str]


class OptimiseOptions(Options, total=False):
    """Options of an optimisation."""

    maximise: str
    minimise: str
    keep_margins: bool
    grid: int
    steady_state: bool
    storage_voltage: float
    """In V."""
    single_start: bool
    output: str | os.PathLike[str]
    picture: str | os.PathLike[str]


class BudgetOptions(TypedDict, total=False):
    """Options of the day of a node."""

    exact: bool
    learning_days: int
    precision: str
    tolerance: float
    svg: str | os.PathLike[str]


class NeedsOptions(TypedDict, total=False):
    """Options of what a scene needs."""

    accuracy: float
    emit: str | os.PathLike[str]


class PlotOptions(Options, total=False):
    """Options of a picture."""

    view: str | Sequence[str]
    quantity: str | Sequence[str]
    highest: float
    """In Hz."""
    log: str | Sequence[str]


class ResonanceOptions(Options, total=False):
    """Options of the search for resonances."""

    points: int
    short_open: bool
    storage_voltage: float
    """In V."""


class ToleranceOptions(Options, total=False):
    """Options of a tolerance."""

    parts: str | os.PathLike[str]
    samples: int
    seed: int
    quantity: str
    at_least: float
    steady_state: bool
    storage_voltage: float
    """In V."""
    node: bool
    no_accuracy: bool
    single_start: bool
    output: str | os.PathLike[str]
    part: str
    merge: int


Rows = list[dict[str, Any]]
Function = TypeVar("Function", bound=Callable[..., Any])


def _with_old_names(function: Function) -> Function:
    """Takes ``set`` for ``changes``, the name until 0.1, with a warning."""

    @functools.wraps(function)
    def call(*given: Any, **named: Any) -> Any:
        if "set" in named:
            if "changes" in named:
                raise TypeError("`set` is an old name of `changes`; give one of them")
            warnings.warn("the keyword `set` is now `changes`", DeprecationWarning, stacklevel=2)
            named["changes"] = named.pop("set")
        return function(*given, **named)

    return call  # type: ignore[return-value]


def __getattr__(name: str) -> Any:
    if name == "map":
        warnings.warn("`map` is now `response_map`", DeprecationWarning, stacklevel=2)
        return response_map
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


@_with_old_names
def run(
    scene: Source,
    *,
    changes: Changes | None = None,
    trace_every: float | None = None,
    steady_state: bool = False,
    states_accuracy: bool = True,
    **options: Unpack[Options],
) -> dict[str, Any]:
    """Runs a scene.

    Returns the object of ``run --format json`` as a dictionary. With ``trace_every`` in s it has ``trace``, a dictionary of
    arrays of shape (samples,): the recorded motion, one array for each column. ``steady_state`` seeks the periodic steady
    state by shooting in place of the run. Without ``states_accuracy`` the scene is run once only, and the result has no
    accuracy statement.
    """
    arguments = _arguments(options, Options)
    with _file(scene) as path:
        text, trace = _native.run(path, _overrides(changes), arguments, (trace_every, steady_state, states_accuracy))
    found: dict[str, Any] = json.loads(text)
    if trace is not None:
        columns, values = trace
        rows = np.frombuffer(values).reshape(-1, len(columns))
        found["trace"] = {column: rows[:, index].copy() for index, column in enumerate(columns)}
    return found


@_with_old_names
def sweep(
    scene: Source,
    over: Mapping[str, ArrayLike],
    *,
    changes: Changes | None = None,
    steady_state: bool = False,
    states_accuracy: bool = True,
    executor: Executor | None = None,
    points_per_task: int = 1,
    resume: Mapping[str, np.ndarray] | None = None,
    **options: Unpack[Options],
) -> dict[str, np.ndarray]:
    """Runs a scene at all combinations of values, on all cores.

    ``over`` has an array of values for each key, such as ``{"excitation.frequency_hz": np.linspace(15, 25, 41)}``. Returns a
    dictionary of arrays with one axis for each key, in the order of ``over``: the keys themselves, and each result of
    ``run``. A number is a double, not-a-number where there is none; a text, a list or an object is an element of an array of
    objects. ``error`` has the reason where a run failed, else ``None``.

    Any ``concurrent.futures.Executor`` runs the points in its workers, ``points_per_task`` in each task: that of
    ``dask.distributed.Client.get_executor()``, ``mpi4py.futures``, ``loky``. The results have the same bits, ``processor_s``
    aside. Bad input of a point is raised when its task has run; tasks that have not begun are cancelled then. Points whose
    worker is lost have an ``error``, unless the executor submits them again; ``resume``, the result of such a sweep of the same
    scene with the same values, changes and options, runs these alone.
    """
    if not over:
        raise ValueError("over: must have a key")
    if points_per_task < 1:
        raise ValueError(f"points_per_task = {points_per_task}: must be at least 1")
    values = {key: np.asarray(of_key, dtype=float).ravel() for key, of_key in over.items()}
    grid = dict(zip(values, np.meshgrid(*values.values(), indexing="ij")))
    shape = tuple(len(of_key) for of_key in values.values())
    points = np.stack([of_key.ravel() for of_key in grid.values()], axis=1)
    call = functools.partial(
        _rows, scene, _overrides(changes), list(values), _arguments(options, Options), (steady_state, states_accuracy)
    )
    kept = [None] * len(points) if resume is None else _finished(resume, grid)
    open_points = points[[row is None for row in kept]].tolist()
    found = iter(call(open_points) if executor is None else _in_tasks(executor, points_per_task, call, open_points))
    rows = [next(found) if row is None else row for row in kept]
    names = dict.fromkeys(name for row in rows for name in row)
    names.setdefault("error")
    return {**grid, **{name: _array(name, [row.get(name) for row in rows], shape) for name in names}}


def records(swept: Mapping[str, np.ndarray]) -> list[dict[str, Any]]:
    """The points of a sweep as one dictionary each, as ``pandas.DataFrame`` takes them."""
    return [dict(zip(swept, point)) for point in zip(*(of_name.ravel().tolist() for of_name in swept.values()))]


def _rows(
    scene: Source,
    changes: list[tuple[str, str]],
    keys: list[str],
    arguments: list[str],
    how: tuple[bool, bool],
    points: list[list[float]],
) -> list[dict[str, Any]]:
    """The results at some points, in a worker."""
    with _file(scene) as path:
        return [json.loads(text) for text in _native.sweep(path, changes, keys, points, arguments, how)]


def _in_tasks(
    executor: Executor, size: int, call: Callable[..., Rows], points: list[list[float]]
) -> Iterator[dict[str, Any]]:
    """The results of all points, in their order; bad input is raised, another failure is that of the points of its task."""
    parts = [points[first : first + size] for first in range(0, len(points), size)]
    tasks = [_submitted(executor, call, part) for part in parts]
    try:
        for task, part in zip(tasks, parts):
            try:
                yield from task.result()
            except (ValueError, TypeError):
                raise
            except Exception as error:
                yield from ({"error": f"{type(error).__name__}: {error}"} for _ in part)
    finally:
        for task in tasks:
            task.cancel()


def _submitted(executor: Executor, call: Callable[..., Rows], part: list[list[float]]) -> Future[Rows]:
    """The task of some points; that of a pool which takes no more has its error."""
    try:
        return executor.submit(call, part)
    except RuntimeError as error:
        lost: Future[Rows] = Future()
        lost.set_exception(error)
        return lost


def _finished(resume: Mapping[str, np.ndarray], grid: Mapping[str, np.ndarray]) -> list[dict[str, Any] | None]:
    """The rows of a sweep without an error, ``None`` for each with one."""
    for key, of_key in grid.items():
        if key not in resume or not np.array_equal(resume[key], of_key):
            raise ValueError(f"resume: has other values of {key}")
    if "error" not in resume:
        raise ValueError("resume: is no result of a sweep, which has `error`")
    rows = records({name: of_name for name, of_name in resume.items() if name not in grid})
    # Not-a-number alone differs from itself.
    kept = [{name: None if value != value else value for name, value in row.items()} for row in rows]
    return [row if row["error"] is None else None for row in kept]


@dataclasses.dataclass(frozen=True)
class Map:
    """A response map: the steady output power of a harvester over amplitude and frequency, as a node has it in flash."""

    image: bytes
    """The words of the map, little-endian."""
    fingerprint: int
    """Of the harvester."""
    agreement: dict[str, float]
    """How well the map agrees with the full model at random places."""
    picture: str = dataclasses.field(repr=False)
    """The map as SVG."""
    page: str = dataclasses.field(repr=False)
    """All slices of the map as an HTML page with zoom, and with the output power at the pointer."""
    _module: str = dataclasses.field(repr=False)

    def at(
        self, amplitude_m_per_s2: ArrayLike, frequency_hz: ArrayLike, voltage_v: float | None = None
    ) -> dict[str, np.ndarray]:
        """Looks places up, by the code of the node; the arguments are broadcast.

        Returns arrays of the broadcast shape: ``value``, ``low`` and ``high`` in W, or behind a bridge in A: the value of the
        smaller motion, and the bounds of all; not-a-number outside the map. ``motion`` is 0 for the lower motion, 1 for the
        upper one, 2 where there are both, 3 outside.
        """
        amplitude, frequency = np.broadcast_arrays(
            np.asarray(amplitude_m_per_s2, dtype=float), np.asarray(frequency_hz, dtype=float)
        )
        places = np.stack([amplitude.ravel(), frequency.ravel()], axis=1).tolist()
        values, motions = _native.look_up(self.image, self.fingerprint, places, voltage_v)
        numbers = np.frombuffer(values).reshape(*amplitude.shape, 3)
        return {
            "value": numbers[..., 0].copy(),
            "low": numbers[..., 1].copy(),
            "high": numbers[..., 2].copy(),
            "motion": np.frombuffer(motions, dtype=np.uint8).reshape(amplitude.shape).copy(),
        }

    def module(self, command: str = "vibration_harvester.response_map") -> str:
        """The map as a Rust module for firmware; ``command`` is named in its head."""
        return self._module.replace(_COMMAND, " ".join(command.split()), 1)

    def _repr_svg_(self) -> str:
        return self.picture


# What stands for the command in the head of a module.
_COMMAND = "vibration_harvester"


@_with_old_names
def response_map(
    scene: Source,
    amplitude: Sequence[float],
    frequency: Sequence[float],
    *,
    voltage: ArrayLike = (),
    error: float = 0.02,
    places: int = 300,
    seed: int = 1,
    changes: Changes | None = None,
    **options: Unpack[Options],
) -> Map:
    """Makes the response map of a scene, on all cores: a matter of a minute or two of one core.

    ``amplitude`` in m/s² and ``frequency`` in Hz are pairs (lowest, highest), ``voltage`` the rising voltages of the storage
    behind a bridge in V. ``places`` random places measure the bounds, as many others check them.
    """
    ranges = [tuple(float(number) for number in pair) for pair in (amplitude, frequency)]
    voltages = np.asarray(voltage, dtype=float).ravel().tolist()
    arguments = _arguments(options, Options)
    with _file(scene) as path:
        image, fingerprint, agreement, picture, page, module = _native.response_map(
            path, _overrides(changes), ranges, voltages, (error, places, seed), arguments, _COMMAND
        )
    return Map(image, fingerprint, json.loads(agreement), picture, page, module)


@_with_old_names
def fit(
    scene: Source,
    data: str | os.PathLike[str] | Iterable[str | os.PathLike[str]] = (),
    free: str | Iterable[str] = (),
    *,
    changes: Changes | None = None,
    **options: Unpack[FitOptions],
) -> dict[str, Any]:
    """Fits parameters of a scene to measurements, on all cores.

    ``data`` are CSV files, ``free`` keys, each as ``"KEY"`` or ``"KEY=LOW:HIGH"``; without them those of the table ``[fit]`` of
    the scene. Returns the object of ``fit --format json``: ``parameters`` with ``value``, ``standard_error`` and
    ``interval_95``, ``correlation``, ``identifiable``, ``converged`` and others. ``output`` is the file for the fitted scene,
    ``picture`` that for data, model and residuals. With ``output`` a fit that has not converged, or whose data do not determine
    all free keys, raises ``RuntimeError``, because the file is not written then.
    """
    arguments = [*_repeated("data", data), *_repeated("free", free), *_arguments(options, FitOptions)]
    return _of_command("fit", scene, changes, arguments)


@_with_old_names
def optimise(
    scene: Source,
    over: Mapping[str, Sequence[Any]],
    *,
    subject_to: str | Iterable[str] = (),
    changes: Changes | None = None,
    **options: Unpack[OptimiseOptions],
) -> dict[str, Any]:
    """Seeks the values of one to four keys at which a number of the result is largest or smallest, on all cores.

    ``over`` has the range of each key, (low, high) or (low, high, "log"), ``maximise`` or ``minimise`` the number,
    ``subject_to`` bounds such as ``"peak_gap_m<=0.004"``. Returns the object of ``optimise --format json``: ``value``,
    ``point``, ``range_within_1_percent`` and others.
    """
    ranges = [f"{key}={_range(ends)}" for key, ends in over.items()]
    arguments = [*_repeated("over", ranges), *_repeated("subject-to", subject_to), *_arguments(options, OptimiseOptions)]
    return _of_command("optimise", scene, changes, arguments)


def budget(scene: Source, *, changes: Changes | None = None, **options: Unpack[BudgetOptions]) -> dict[str, Any]:
    """Simulates a day of the node of a scene, whose table is ``[node]``.

    Returns the object of ``budget --format json``: energies over the day in J (``harvested_energy_j``, ``income_j``,
    ``leaked_j``), ``lowest_voltage_v``, ``lockouts``, ``capacitance_for_wishes_f`` in F, ``actions``, ``estimation`` and
    ``figures`` as lists of dictionaries, and ``verdict``. ``exact`` takes every step of the harvester, ``learning_days`` come
    before the day, ``svg`` is a file for the picture; without it nothing is written.
    """
    return _of_command("budget", scene, changes, _arguments(options, BudgetOptions))


def resonance(
    scene: Source,
    frequency: Sequence[float],
    *,
    changes: Changes | None = None,
    **options: Unpack[ResonanceOptions],
) -> dict[str, Any]:
    """Seeks the frequencies at which the periodic steady state of a scene has its largest amplitude, voltage and power.

    ``frequency`` is the pair (lowest, highest) in Hz, ``points`` the number of frequencies of the first scan. Returns the object
    of ``resonance --format json``: ``peak_frequency_hz``, ``peak_amplitude_m``, ``max_rms_voltage_frequency_hz``,
    ``max_rms_voltage_v``, ``max_mean_power_frequency_hz``, ``max_mean_power_w`` and others, each with ``…_within_hz`` and whether
    it is at an edge. With ``short_open`` those with short-circuited and with open terminals, and ``coupling_factor_squared``.
    """
    low, high = frequency
    arguments = [f"--from={low}", f"--to={high}", *_arguments(options, ResonanceOptions)]
    return _of_command("resonance", scene, changes, arguments)


def needs(
    scene: Source,
    *,
    amplitude: Sequence[float] | None = None,
    frequency: Sequence[float] | None = None,
    changes: Changes | None = None,
    **options: Unpack[NeedsOptions],
) -> dict[str, Any]:
    """Finds which parts of a scene its mean power needs, and what runs the scene without the others.

    ``accuracy`` is the relative change that is accepted. ``amplitude`` in m/s² and ``frequency`` in Hz are pairs (lowest,
    highest), at which it must hold too; ``emit`` is a file for the cut scene as a Rust module. Returns the object of
    ``needs --format json``: ``full``, the result of the full scene, ``parts`` and ``numerics`` as lists of dictionaries,
    ``left_out`` as a list of names, and ``without_all``, the relative changes without all of them.
    """
    ranges = {"amplitude": amplitude, "frequency": frequency}
    arguments = [f"--{name}={_range(ends)}" for name, ends in ranges.items() if ends is not None]
    return _of_command("needs", scene, changes, arguments + _arguments(options, NeedsOptions))


def tolerance(
    scene: Source,
    vary: Mapping[str, Any] | None = None,
    *,
    correlate: Mapping[tuple[str, str], float] | None = None,
    changes: Changes | None = None,
    **options: Unpack[ToleranceOptions],
) -> dict[str, Any] | None:
    """Draws samples of keys that vary from part to part, on all cores: how a number of the result spreads.

    ``vary`` has the bound of each key: a number in the unit of the key, or a text such as ``"±2%"`` or ``"±5%:normal"``, where the
    bound is two standard deviations. ``correlate`` has the correlation of pairs of normal keys, ``parts`` is a CSV file of measured
    parts. Returns the object of ``tolerance --format json``: ``statistics``, a list of dictionaries with ``name``, ``value``,
    ``confidence_low`` and ``confidence_high`` in the unit of ``quantity`` (``mean_power_w``), ``keys``, a list in the order in
    which they matter, and others. ``output`` is a folder for table and pictures, and keeps the samples of an interrupted call.
    With ``part="3/16"`` a job of an array keeps its samples there, and returns ``None``; ``merge=16`` has the result of all.
    """
    bounds = [f"{key}={bound if isinstance(bound, str) else f'±{_toml(bound)}'}" for key, bound in (vary or {}).items()]
    pairs = [f"{one},{other}={value}" for (one, other), value in (correlate or {}).items()]
    arguments = [*_repeated("vary", bounds), *_repeated("correlate", pairs), *_arguments(options, ToleranceOptions)]
    return _of_command("tolerance", scene, changes, arguments)


def validation(*, picture: str | os.PathLike[str] | None = None) -> Rows:
    """Puts published measurements beside the models.

    Returns the list of ``validation --format json``: a dictionary for each figure with ``source``, ``quantity`` with its unit,
    ``measured``, ``ours``, ``relative_difference``, and ``fitted``, whether a parameter was fitted to it. ``picture`` is a file
    (.svg or .html).
    """
    arguments = [] if picture is None else [f"--picture={os.fspath(picture)}"]
    found: Rows = json.loads(_native.command(["validation", "--format=json", *arguments]))
    return found


@dataclasses.dataclass(frozen=True)
class Picture:
    """The motion of runs. A notebook draws it."""

    svg: str = dataclasses.field(repr=False)
    page: str = dataclasses.field(repr=False)
    """An HTML page with zoom, and with the values at the pointer."""
    accuracy: dict[str, Any]
    """The statement of the runs."""
    warnings: list[str]

    def save(self, file: str | os.PathLike[str]) -> None:
        """Writes the page to a file that ends in .html, the SVG to another."""
        path = pathlib.Path(file)
        path.write_text(self.page if path.suffix.lower() == ".html" else self.svg, encoding="utf-8")

    def _repr_svg_(self) -> str:
        return self.svg


def plot(
    scene: Source,
    *,
    compare: Mapping[str, Sequence[Any]] | None = None,
    span: Sequence[float] | None = None,
    traces: Iterable[str | os.PathLike[str]] = (),
    changes: Changes | None = None,
    **options: Unpack[PlotOptions],
) -> Picture:
    """Draws the motion of a run, or of a run for each value of a key.

    ``compare`` has up to six values of one key, ``span`` is the pair of the first and last instant in s of time histories and phase
    portrait, ``traces`` are CSV files to draw beside the runs. ``view`` is any of history, phase, spectrum and energy,
    ``quantity`` the columns of the time histories, ``highest`` the highest frequency of the spectrum in Hz, ``log`` its
    logarithmic axes, x and y. Each run is made once.
    """
    arguments = [os.fspath(trace) for trace in traces]
    for key, values in (compare or {}).items():
        arguments.append(f"--compare={key}={','.join(value if isinstance(value, str) else _toml(value) for value in values)}")
    arguments += [] if span is None else [f"--from={span[0]}", f"--to={span[1]}"]
    found = _of_command("plot", scene, changes, arguments + _arguments(options, PlotOptions))
    return Picture(found["svg"], found["page"], found["accuracy"], found["warnings"])


def _of_command(name: str, scene: Source, changes: Changes | None, arguments: Iterable[str]) -> dict[str, Any]:
    """The result of a command, which is an object but of a part of a tolerance."""
    # The result of `plot` has one format.
    format_ = [] if name == "plot" else ["--format=json"]
    with _file(scene) as path:
        # A part of a tolerance prints nothing.
        found: dict[str, Any] = json.loads(_native.command([name, path, *format_, *_given(changes), *arguments]) or "null")
    return found


@contextlib.contextmanager
def _file(scene: Source) -> Iterator[str]:
    """The path of a scene file: that of the caller, or of a temporary one with the text or the tables."""
    if isinstance(scene, Mapping):
        text = "\n".join(f"{key} = {_toml(value)}" for key, value in scene.items())
    elif isinstance(scene, str) and "\n" in scene:
        text = scene
    else:
        yield os.fspath(scene)
        return
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "scene.toml"
        path.write_text(text, encoding="utf-8")
        try:
            yield str(path)
        except (ValueError, RuntimeError) as error:
            kind = ValueError if isinstance(error, ValueError) else RuntimeError
            raise kind(str(error).replace(str(path), "scene")) from None


def _given(changes: Changes | None) -> list[str]:
    """Keys and values as one option each."""
    return [f"--set={key}={value}" for key, value in _overrides(changes)]


def _range(ends: Iterable[Any]) -> str:
    """Ends of a range as the command line has them."""
    return ":".join(str(end) for end in ends)


def _repeated(name: str, values: Any) -> list[str]:
    """An option for each value; a single text is one value."""
    values = [values] if isinstance(values, (str, os.PathLike)) else values
    return [f"--{name}={value}" for value in values]


def _overrides(changes: Changes | None) -> list[tuple[str, str]]:
    """Keys and values as the command line has them."""
    return [(key, _toml(value)) for key, value in (changes or {}).items()]


def _toml(value: Any) -> str:
    """A value as a scene file has it: numbers, texts, truth values, lists and tables."""
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_toml(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml(entry) for entry in value) + "]"
    if isinstance(value, (str, os.PathLike)):
        return json.dumps(os.fspath(value), ensure_ascii=False)
    if value is None:
        raise ValueError("None is no value of a key; leave the key out")
    return repr(value.item() if isinstance(value, np.generic) else value)


def _arguments(options: Mapping[str, Any], known: type) -> list[str]:
    """Options as arguments of the command line; one that is True has no value there."""
    for name in options:
        if name not in known.__annotations__:
            names = ", ".join(known.__annotations__)
            raise TypeError(f"{name!r} is no option; the options are {names}")
    arguments = []
    for name, value in options.items():
        argument = f"--{name.replace('_', '-')}"
        if isinstance(value, (bool, np.bool_)):
            arguments += [argument] if value else []
        elif value is not None:
            values = value if isinstance(value, (list, tuple)) else [value]
            arguments.append(f"{argument}={','.join(map(str, values))}")
    return arguments


# Results that are no numbers, though a point may lack them.
_OBJECTS = {"accuracy", "error", "math", "method", "precision", "scene", "steady_state", "warnings"}


def _array(name: str, values: list[Any], shape: tuple[int, ...]) -> np.ndarray:
    """Values of one name at all points: doubles if all are numbers or absent, else objects."""
    if name not in _OBJECTS and all(value is None or type(value) in (int, float) for value in values):
        numbers = [np.nan if value is None else value for value in values]
        return np.array(numbers, dtype=float).reshape(shape)
    array = np.empty(len(values), dtype=object)
    array[:] = values
    return array.reshape(shape)
