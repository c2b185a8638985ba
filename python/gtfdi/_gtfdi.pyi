from collections.abc import Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, TypeAlias, TypedDict, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "Arx",
    "ArxModel",
    "Bank",
    "Dataset",
    "Detection",
    "Detector",
    "FreeRun",
    "Observer",
    "OrderTable",
    "OutputModel",
    "Run",
    "StateSpace",
    "Verdict",
    "VerdictSeries",
    "__version__",
    "arx",
    "design",
    "observer",
    "order_table",
    "read",
    "simulate",
    "steady_state",
    "units",
]

__version__: str

_Path: TypeAlias = str | PathLike[str]
_Names: TypeAlias = str | Sequence[str]
_Numbers: TypeAlias = int | Sequence[int]
_Poles: TypeAlias = float | Sequence[float]
_Structure: TypeAlias = Literal["canonical", "full", "diag"]
_Doubles: TypeAlias = NDArray[np.float64]
_Flags: TypeAlias = NDArray[np.bool_]

class _Point(TypedDict):
    u: _Doubles
    y: _Doubles

class _Term(TypedDict):
    signal: str
    lag: int
    coefficient: float

class _OutputFit(TypedDict):
    name: str
    fit_prediction_percent: float
    fit_simulation_percent: float | None
    ppcre_prediction_percent: float
    ppcre_simulation_percent: float | None
    sse_prediction: float
    sse_simulation: float | None
    diverges_at_s: float | None

class _OrderRow(TypedDict):
    order: int
    parameters: int
    residual_variance: list[float]
    ln_det: float | None
    aic: float | None
    mdl: float | None
    fpe: float | None
    ppcre_percent: float
    condition: float | None

class _BestOrder(TypedDict):
    aic: int
    mdl: int
    fpe: int

class _Alarm(TypedDict):
    time_s: float
    first_exceedance_s: float
    tag: str
    residual: float
    threshold: float
    end_s: float | None

class _FalseAlarmRate(TypedDict):
    alarms: int
    hours: float
    per_hour: float
    per_hour_low: float
    per_hour_high: float

class _FalseAlarms(TypedDict):
    in_sample: _FalseAlarmRate
    cross_validated: _FalseAlarmRate
    cross_validated_exceedance_share: float

class _OutputDetector(TypedDict):
    output: str
    poles: list[float]
    limit: float
    consecutive: int
    settle_samples: int
    false_alarms: _FalseAlarms

@final
class Dataset:
    def __new__(
        cls,
        u: ArrayLike,
        y: ArrayLike,
        sample_time_s: float,
        inputs: _Names | None = None,
        outputs: _Names | None = None,
        input_units: _Names | None = None,
        output_units: _Names | None = None,
        start_time_s: float = 0.0,
    ) -> Dataset: ...
    @property
    def u(self) -> _Doubles: ...
    @property
    def y(self) -> _Doubles: ...
    @property
    def time_s(self) -> _Doubles: ...
    @property
    def inputs(self) -> list[str]: ...
    @property
    def outputs(self) -> list[str]: ...
    @property
    def input_units(self) -> list[str]: ...
    @property
    def output_units(self) -> list[str]: ...
    @property
    def sample_time_s(self) -> float: ...
    @property
    def start_time_s(self) -> float: ...
    def select(self, inputs: _Names, outputs: _Names) -> Dataset: ...
    def __len__(self) -> int: ...
    def __getitem__(self, rows: slice, /) -> Dataset: ...

_Healthy: TypeAlias = Dataset | tuple[ArrayLike, ArrayLike]
_Record: TypeAlias = Dataset | ArrayLike | tuple[ArrayLike, ArrayLike]

@final
class Run:
    @property
    def truth(self) -> Dataset: ...
    @property
    def measured(self) -> Dataset: ...
    @property
    def hidden(self) -> _Doubles: ...
    @property
    def hidden_names(self) -> list[str]: ...
    @property
    def ended(self) -> str | None: ...
    @property
    def faults(self) -> _Doubles: ...
    @property
    def fault_names(self) -> list[str]: ...
    @property
    def fault_units(self) -> list[str]: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def config(self) -> str: ...
    def write(self, path: _Path) -> None: ...
    def __len__(self) -> int: ...

@final
class StateSpace:
    def __new__(
        cls,
        A: ArrayLike,
        B: ArrayLike,
        C: ArrayLike,
        D: ArrayLike,
        dt: float,
        inputs: _Names | None = None,
        outputs: _Names | None = None,
    ) -> StateSpace: ...
    @property
    def A(self) -> _Doubles: ...
    @property
    def B(self) -> _Doubles: ...
    @property
    def C(self) -> _Doubles: ...
    @property
    def D(self) -> _Doubles: ...
    @property
    def dt(self) -> float: ...
    @property
    def inputs(self) -> list[str]: ...
    @property
    def outputs(self) -> list[str]: ...
    def poles(self) -> NDArray[np.complex128]: ...
    def simulate(self, u: ArrayLike, x0: ArrayLike | None = None) -> _Doubles: ...
    def markov_parameters(self, n: int) -> _Doubles: ...
    def to_json(self) -> str: ...
    @classmethod
    def from_json(cls, text: str) -> StateSpace: ...

@final
class OutputModel:
    @property
    def model(self) -> StateSpace: ...
    @property
    def point(self) -> _Point: ...

@final
class FreeRun:
    @property
    def y(self) -> _Doubles: ...
    @property
    def diverges_at(self) -> list[int | None]: ...
    @property
    def diverged(self) -> bool: ...

@final
class ArxModel:
    @property
    def inputs(self) -> list[str]: ...
    @property
    def outputs(self) -> list[str]: ...
    @property
    def sample_time_s(self) -> float: ...
    @property
    def operating_point(self) -> _Point: ...
    @property
    def structure(self) -> dict[str, dict[str, Any]]: ...
    @property
    def regression(self) -> list[list[_Term]]: ...
    @property
    def max_lag(self) -> int: ...
    @property
    def rows_used(self) -> int: ...
    @property
    def residual_variance(self) -> _Doubles: ...
    @property
    def condition(self) -> _Doubles: ...
    def predict(self, u: _Record, y: ArrayLike | None = None) -> _Doubles: ...
    def equation_error(self, u: _Record, y: ArrayLike | None = None) -> _Doubles: ...
    def simulate(self, u: _Record, y: ArrayLike | None = None) -> FreeRun: ...
    def validate(self, u: _Record, y: ArrayLike | None = None) -> list[_OutputFit]: ...
    def state_space(self) -> StateSpace: ...
    def output_model(self, output: int | str) -> OutputModel: ...
    def save(self, path: _Path) -> None: ...
    @classmethod
    def load(cls, path: _Path) -> ArxModel: ...
    def to_json(self) -> str: ...
    @classmethod
    def from_json(cls, text: str) -> ArxModel: ...

@final
class Arx:
    def __new__(
        cls,
        *,
        order: int | tuple[int, int] | Literal["auto"] | None = None,
        na: int | None = None,
        nb: _Numbers | None = None,
        nk: _Numbers = 1,
        indices: Sequence[int] | None = None,
        structure: _Structure | None = None,
    ) -> Arx: ...
    def fit(
        self,
        u: _Record,
        y: ArrayLike | None = None,
        *,
        sample_time_s: float | None = None,
        inputs: _Names | None = None,
        outputs: _Names | None = None,
    ) -> ArxModel: ...

@final
class OrderTable:
    @property
    def window_rows(self) -> int: ...
    @property
    def best(self) -> _BestOrder: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[_OrderRow]: ...
    def __getitem__(self, index: int, /) -> _OrderRow: ...

@final
class Observer:
    def residual(self, u: _Record, y: ArrayLike | None = None) -> _Doubles: ...
    @property
    def gain(self) -> _Doubles: ...
    @property
    def poles(self) -> _Doubles: ...
    @property
    def settle_samples(self) -> int: ...
    @property
    def model(self) -> StateSpace: ...
    @property
    def point(self) -> _Point: ...
    def to_json(self) -> str: ...
    @classmethod
    def from_json(cls, text: str) -> Observer: ...

@final
class Detection:
    @property
    def time_s(self) -> _Doubles: ...
    @property
    def outputs(self) -> list[str]: ...
    @property
    def residuals(self) -> _Doubles: ...
    @property
    def alarms(self) -> list[_Alarm]: ...
    @property
    def share_above_limit(self) -> _Doubles: ...

@final
class Bank:
    @property
    def name(self) -> str: ...
    @property
    def inputs(self) -> list[str]: ...
    @property
    def outputs(self) -> list[str]: ...
    @property
    def sample_time_s(self) -> float: ...
    @property
    def detectors(self) -> list[_OutputDetector]: ...
    def detect(self, u: _Record, y: ArrayLike | None = None) -> Detection: ...
    def detector(self) -> Detector: ...
    def save(self, path: _Path) -> None: ...
    @classmethod
    def load(cls, path: _Path) -> Bank: ...
    def to_json(self) -> str: ...
    @classmethod
    def from_json(cls, text: str) -> Bank: ...

@final
class Detector:
    @property
    def inputs(self) -> list[str]: ...
    @property
    def outputs(self) -> list[str]: ...
    @property
    def sample_time_s(self) -> float: ...
    def step(self, u: ArrayLike, y: ArrayLike, t_s: float | None = None) -> Verdict: ...
    def process(
        self, u: _Record, y: ArrayLike | None = None, t_s: float | None = None
    ) -> VerdictSeries: ...
    def reset(self) -> None: ...

@final
class Verdict:
    @property
    def outputs(self) -> list[str]: ...
    @property
    def time_s(self) -> float: ...
    @property
    def gap(self) -> bool: ...
    @property
    def residual(self) -> _Doubles: ...
    @property
    def exceeds(self) -> _Flags: ...
    @property
    def run_length(self) -> NDArray[np.uintp]: ...
    @property
    def alarm(self) -> _Flags: ...
    @property
    def new_alarm(self) -> _Flags: ...
    @property
    def first_exceedance_s(self) -> _Doubles: ...
    @property
    def settling(self) -> _Flags: ...

@final
class VerdictSeries:
    @property
    def outputs(self) -> list[str]: ...
    @property
    def time_s(self) -> _Doubles: ...
    @property
    def gap(self) -> _Flags: ...
    @property
    def residual(self) -> _Doubles: ...
    @property
    def exceeds(self) -> _Flags: ...
    @property
    def alarm(self) -> _Flags: ...
    @property
    def new_alarm(self) -> _Flags: ...
    @property
    def first_exceedance_s(self) -> _Doubles: ...
    @property
    def settling(self) -> _Flags: ...
    def __len__(self) -> int: ...

def simulate(
    seconds: float | None = None,
    *,
    scenario: Mapping[str, Any] | _Path | None = None,
    variant: str | None = None,
    seed: int | None = None,
    run_index: int | None = None,
    profile: str | None = None,
    noise: str | Mapping[str, Any] | None = None,
    map_set: str | None = None,
    faults: Sequence[Mapping[str, Any]] | None = None,
    substeps: int | None = None,
) -> Run: ...
def steady_state(
    variant: str = "prototype", map_set: str = "paper"
) -> dict[str, float]: ...
def units(variant: str = "prototype") -> dict[str, str]: ...
def read(
    path: _Path,
    *,
    inputs: _Names,
    outputs: _Names,
    time: str | None = None,
    sample_time_s: float | None = None,
    topic: str | None = None,
    rows: tuple[int, int] | None = None,
) -> Dataset: ...
def arx(
    u: _Record,
    y: ArrayLike | None = None,
    *,
    order: int | tuple[int, int] | Literal["auto"] | None = None,
    na: int | None = None,
    nb: _Numbers | None = None,
    nk: _Numbers = 1,
    indices: Sequence[int] | None = None,
    structure: _Structure | None = None,
    sample_time_s: float | None = None,
    inputs: _Names | None = None,
    outputs: _Names | None = None,
) -> ArxModel: ...
def order_table(
    u: _Record,
    y: ArrayLike | None = None,
    orders: tuple[int, int] = (1, 12),
    *,
    structure: _Structure | None = None,
    nk: _Numbers = 1,
    sample_time_s: float | None = None,
    inputs: _Names | None = None,
    outputs: _Names | None = None,
) -> OrderTable: ...
def observer(
    model: StateSpace | OutputModel,
    poles: _Poles,
    point: tuple[ArrayLike, ArrayLike] | None = None,
) -> Observer: ...
def design(
    model: ArxModel,
    healthy: Sequence[_Healthy],
    *,
    poles: _Poles | Mapping[str, _Poles] | None = None,
    exceedance: float | None = None,
    margin: float | None = None,
    arl0_h: float | None = None,
    consecutive: int | None = None,
) -> Bank: ...
