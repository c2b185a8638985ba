"""Models of python-control and of scipy.signal, to and from `StateSpace`."""

from typing import Any

from gtfdi._extras import need
from gtfdi._gtfdi import StateSpace
from gtfdi.errors import ModelError


def to_control(model: StateSpace) -> Any:
    """A ``control.StateSpace`` with the same matrices, sample time and names."""
    control = need("control", "control")
    matrices = model.A, model.B, model.C, model.D
    return control.ss(*matrices, model.dt, inputs=model.inputs, outputs=model.outputs)


def from_control(system: Any) -> StateSpace:
    """The model of a ``control`` system; a transfer function is realised first."""
    control = need("control", "control")
    if not isinstance(system, control.StateSpace):
        system = control.ss(system)
    dt = _sample_time_s(system.dt, "control system")
    names = {"inputs": list(system.input_labels), "outputs": list(system.output_labels)}
    return StateSpace(system.A, system.B, system.C, system.D, dt, **names)


def to_scipy(model: StateSpace) -> Any:
    """A ``scipy.signal.dlti`` in state space with the same matrices and sample time."""
    signal = need("scipy.signal", "scipy")
    return signal.StateSpace(model.A, model.B, model.C, model.D, dt=model.dt)


def from_scipy(system: Any, inputs: Any, outputs: Any) -> StateSpace:
    """The model of a ``scipy.signal.dlti`` of any form."""
    need("scipy.signal", "scipy")
    own = system.to_ss() if hasattr(system, "to_ss") else system
    dt = _sample_time_s(getattr(own, "dt", None), "scipy system")
    return StateSpace(own.A, own.B, own.C, own.D, dt, inputs, outputs)


def _sample_time_s(dt: Any, what: str) -> float:
    """A sample time in seconds; continuous time and an unknown one are refused."""
    if dt is None or isinstance(dt, bool) or dt == 0:
        raise ModelError(
            f"{what}: expected discrete time with a sample time in seconds, found dt = {dt}"
        )
    return float(dt)
