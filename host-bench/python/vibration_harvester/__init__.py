"""Models of vibration energy harvesters, by the embedded core that runs on a sensor node.

A scene is the path of a scene file. ``set`` changes keys of it, as ``--set`` of the command line does:
``set={"load.resistance_ohm": 1e6}``. Options have the names of the command line with underscores: ``method``,
``precision``, ``math``, ``accuracy``, ``tolerance``, ``step``, ``long_step``. All quantities are in SI units and have their
unit in their name.

Bad input raises ``ValueError``, a run that cannot be stepped to its end ``RuntimeError``. The interpreter lock is released
while the engine runs. Ctrl-C ends the wait for a result at once; a sweep begins no further run, and what runs already goes on
unseen to its end.

A number that a result does not have is ``None`` in a dictionary, and not-a-number in an array of ``sweep``.
"""

import json
import os
import sys

import numpy as np

try:
    from . import _native
except ImportError as error:
    raise ImportError(
        f"vibration_harvester: the native module cannot be loaded ({error}); build it for this Python, "
        f"{sys.version_info.major}.{sys.version_info.minor}, by `pip install ./host-bench/python` with Rust installed"
    ) from error

__all__ = ["Map", "fit", "map", "optimise", "run", "sweep"]


def run(scene, *, set=None, trace_every=None, steady_state=False, states_accuracy=True, **options):
    """Runs a scene.

    Returns the object of ``run --format json`` as a dictionary. With ``trace_every`` in s it has ``trace``, a dictionary of
    arrays: the recorded motion, one array for each column. ``steady_state`` seeks the periodic steady state by shooting in
    place of the run. Without ``states_accuracy`` the scene is run once only, and the result has no accuracy statement.
    """
    text, trace = _native.run(
        scene, _overrides(set), _arguments(options), (trace_every, steady_state, states_accuracy)
    )
    found = json.loads(text)
    if trace is not None:
        columns, values = trace
        rows = np.frombuffer(values).reshape(-1, len(columns))
        found["trace"] = {column: rows[:, index].copy() for index, column in enumerate(columns)}
    return found


def sweep(scene, over, *, set=None, steady_state=False, states_accuracy=True, **options):
    """Runs a scene at all combinations of values, on all cores.

    ``over`` has an array of values for each key, such as ``{"excitation.frequency_hz": np.linspace(15, 25, 41)}``. Returns a
    dictionary of arrays with one axis for each key, in the order of ``over``: the keys themselves, and each result of
    ``run``. A number is a double, not-a-number where there is none; a text, a list or an object is an element of an array of
    objects. ``error`` has the reason where a run failed, else ``None``.
    """
    keys = [(key, np.asarray(values, dtype=float).ravel().tolist()) for key, values in over.items()]
    texts = _native.sweep(scene, _overrides(set), keys, _arguments(options), (steady_state, states_accuracy))
    rows = [json.loads(text) for text in texts]
    shape = tuple(len(values) for _, values in keys)
    grid = np.meshgrid(*(values for _, values in keys), indexing="ij")
    found = {key: values for (key, _), values in zip(keys, grid)}
    names = dict.fromkeys(name for row in rows for name in row)
    names.setdefault("error")
    found.update((name, _array(name, [row.get(name) for row in rows], shape)) for name in names)
    return found


class Map:
    """A response map: the steady output power of a harvester over amplitude and frequency, as a node has it in flash.

    ``agreement`` is how well it agrees with the full model at random places, ``image`` its bytes, ``picture`` an SVG,
    ``page`` an HTML page.
    """

    def __init__(self, native):
        self._native = native
        self.agreement = json.loads(native.agreement())
        self.image = native.image()

    def at(self, amplitude_m_per_s2, frequency_hz, voltage_v=None):
        """Looks places up, by the code of the node; the arguments are broadcast.

        Returns ``value``, ``low`` and ``high`` in W, or behind a bridge in A: the value of the smaller motion, and the bounds
        of all; not-a-number outside the map. ``motion`` is 0 for the lower motion, 1 for the upper one, 2 where there are
        both, 3 outside.
        """
        amplitude, frequency = np.broadcast_arrays(
            np.asarray(amplitude_m_per_s2, dtype=float), np.asarray(frequency_hz, dtype=float)
        )
        places = np.stack([amplitude.ravel(), frequency.ravel()], axis=1).tolist()
        values, motions = self._native.at(places, voltage_v)
        numbers = np.frombuffer(values).reshape(*amplitude.shape, 3)
        return {
            "value": numbers[..., 0].copy(),
            "low": numbers[..., 1].copy(),
            "high": numbers[..., 2].copy(),
            "motion": np.frombuffer(motions, dtype=np.uint8).reshape(amplitude.shape).copy(),
        }

    def module(self, command="vibration_harvester.map"):
        """The map as a Rust module for firmware; ``command`` is named in its head."""
        return self._native.module(command)

    @property
    def picture(self):
        """A picture of the map as SVG."""
        return self._native.picture()

    @property
    def page(self):
        """All slices of the map as an HTML page with zoom, and with the output power at the pointer."""
        return self._native.page()


def map(scene, amplitude, frequency, *, voltage=(), error=0.02, places=300, seed=1, set=None, **options):
    """Makes the response map of a scene, on all cores: a matter of a minute or two of one core.

    ``amplitude`` in m/s² and ``frequency`` in Hz are pairs (lowest, highest), ``voltage`` the rising voltages of the storage
    behind a bridge in V. ``places`` random places measure the bounds, as many others check them.
    """
    ranges = [tuple(float(number) for number in pair) for pair in (amplitude, frequency)]
    voltages = np.asarray(voltage, dtype=float).ravel().tolist()
    return Map(_native.map(scene, _overrides(set), ranges, voltages, (error, places, seed), _arguments(options)))


def fit(scene, data=(), free=(), *, set=None, loss=None, starts=None, output=None, picture=None, **options):
    """Fits parameters of a scene to measurements, on all cores.

    ``data`` are CSV files, ``free`` keys, each as ``"KEY"`` or ``"KEY=LOW:HIGH"``; without them those of the table ``[fit]`` of
    the scene. Returns the object of ``fit --format json``: ``parameters`` with ``value``, ``standard_error`` and
    ``interval_95``, ``correlation``, ``identifiable``, ``converged`` and others. ``output`` is the file for the fitted scene,
    ``picture`` that for data, model and residuals. With ``output`` a fit that has not converged, or whose data do not determine
    all free keys, raises ``RuntimeError``, because the file is not written then.
    """
    arguments = [str(scene), *_given("set", set), *_repeated("data", data), *_repeated("free", free)]
    arguments += _arguments({"loss": loss, "starts": starts, "output": output, "picture": picture, **options})
    return json.loads(_native.fit(arguments))


def optimise(scene, over, *, maximise=None, minimise=None, subject_to=(), set=None, steady_state=False, **options):
    """Seeks the values of one to four keys at which a number of the result is largest or smallest, on all cores.

    ``over`` has the range of each key, (low, high) or (low, high, "log"), ``subject_to`` bounds such as
    ``"peak_gap_m<=0.004"``. Returns the object of ``optimise --format json``: ``value``, ``point``,
    ``range_within_1_percent`` and others. ``grid``, ``output``, ``picture`` and ``keep_margins=True``
    are those of the command line.
    """
    ranges = [f"{key}={':'.join(str(end) for end in ends)}" for key, ends in over.items()]
    arguments = [str(scene), *_given("set", set), *_repeated("over", ranges), *_repeated("subject-to", subject_to)]
    arguments += ["--steady-state"] if steady_state else []
    arguments += _arguments({"maximise": maximise, "minimise": minimise, **options})
    return json.loads(_native.optimise(arguments))


def _given(name, changes):
    """Keys and values as one option each."""
    return [f"--{name}={key}={value}" for key, value in _overrides(changes)]


def _repeated(name, values):
    """An option for each value; a single text is one value."""
    values = [values] if isinstance(values, (str, os.PathLike)) else values
    return [f"--{name}={value}" for value in values]


def _overrides(changes):
    """Keys and values as the command line has them."""
    return [(key, _toml(value)) for key, value in (changes or {}).items()]


def _toml(value):
    """A value as a scene file has it: numbers, texts, truth values, lists and tables."""
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_toml(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, (list, tuple, np.ndarray)):
        return "[" + ", ".join(_toml(entry) for entry in value) + "]"
    if isinstance(value, str):
        return json.dumps(value)
    return repr(value.item() if isinstance(value, np.generic) else value)


def _arguments(options):
    """Options as arguments of the command line; one that is True has no value there."""
    given = [(name, value) for name, value in options.items() if value is not None and value is not False]
    named = [(f"--{name.replace('_', '-')}", value) for name, value in given]
    return [name if value is True else f"{name}={value}" for name, value in named]


# Results that are no numbers, though a point may lack them.
_OBJECTS = {"accuracy", "error", "math", "method", "precision", "scene", "steady_state", "warnings"}


def _array(name, values, shape):
    """Values of one name at all points: doubles if all are numbers or absent, else objects."""
    if name not in _OBJECTS and all(value is None or type(value) in (int, float) for value in values):
        numbers = [np.nan if value is None else value for value in values]
        return np.array(numbers, dtype=float).reshape(shape)
    array = np.empty(len(values), dtype=object)
    array[:] = values
    return array.reshape(shape)
