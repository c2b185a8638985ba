from collections.abc import Callable, Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, TypeAlias, TypedDict, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "AdaptiveThreshold",
    "Arx",
    "ArxFit",
    "ArxModel",
    "Bank",
    "ConstrainedArx",
    "ConstrainedFit",
    "Cusum",
    "CusumFleet",
    "Dataset",
    "Detection",
    "Detector",
    "EivKalman",
    "EivModel",
    "EivOrderTable",
    "FaultModel",
    "FilterRun",
    "Fleet",
    "FreeRun",
    "FrequencyResponse",
    "FrischOrderTable",
    "Glr",
    "GrowingChiSquare",
    "GrowingVariance",
    "IndexTable",
    "Isolation",
    "IsolationMonitor",
    "Isolator",
    "KalmanFilter",
    "LinearResidual",
    "MovingAverage",
    "NoiseCovariance",
    "Observer",
    "ObserverDesign",
    "OrderTable",
    "OutputErrorRefinement",
    "OutputModel",
    "Refined",
    "ResidualReport",
    "Riccati",
    "Run",
    "RunSum",
    "ScheduledArx",
    "ScheduledGenerators",
    "ScheduledModel",
    "ShiryaevRoberts",
    "SignatureMatrix",
    "SimulatedRuns",
    "Sprt",
    "StateSpace",
    "TimeVaryingKalman",
    "Trend",
    "UnifiedFilter",
    "UnknownInputObserver",
    "Verdict",
    "VerdictSeries",
    "Whiteness",
    "WindowedChiSquare",
    "WindowedVariance",
    "__version__",
    "_CampaignDesk",
    "_CampaignTask",
    "_restore",
    "arx",
    "campaign_compare",
    "campaign_rows",
    "campaign_run",
    "check",
    "cusum_run_length",
    "cusum_threshold",
    "design",
    "design_isolator",
    "eiv",
    "eiv_order_table",
    "exceedance_limit",
    "exceedance_run_length",
    "fault_effects",
    "feature",
    "frisch",
    "frisch_order_table",
    "index_table",
    "kalman",
    "lag_limit",
    "linearise",
    "log_attachment",
    "log_export",
    "log_info",
    "log_messages",
    "log_recover",
    "log_verify",
    "mean_delay_bound",
    "observer",
    "optimise_observer",
    "order_table",
    "peak_gain",
    "place",
    "read",
    "reproduce",
    "riccati",
    "robustness",
    "run_sum_run_length",
    "run_sum_width",
    "shiryaev_roberts_run_length",
    "shiryaev_roberts_threshold",
    "signature",
    "simulate",
    "steady_state",
    "units",
    "write_report",
]

__version__: str

_Path: TypeAlias = str | PathLike[str]
_Names: TypeAlias = str | Sequence[str]
_Numbers: TypeAlias = int | Sequence[int]
_Poles: TypeAlias = complex | Sequence[complex] | NDArray[np.number]
_Structure: TypeAlias = Literal["canonical", "full", "diag"]
_Order: TypeAlias = int | tuple[int, int] | Literal["auto"]
_Centre: TypeAlias = Literal["means", "zero"] | tuple[ArrayLike, ArrayLike]
_Missing: TypeAlias = Literal["refuse", "break"]
_EquationErrors: TypeAlias = Literal["uncorrelated", "correlated"]
_Solver: TypeAlias = Literal["qr", "automatic"]
_Gain: TypeAlias = float | tuple[float, float] | Literal["positive", "negative"]
_SolvedBy: TypeAlias = Literal["qr", "refinement", "joint"]
_Outcome: TypeAlias = Literal["not_rejected", "rejected", "untested"]
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

class _EivOrderRow(TypedDict):
    order: int
    parameters: int
    criterion: float
    aic: float
    bic: float
    converged: bool

class _BestEivOrder(TypedDict):
    aic: int
    bic: int

class _FrischOrderRow(TypedDict):
    order: int
    surface_gap: float | None
    yule_walker: float | None
    rank_ratio: float | None
    statistic: float | None
    degrees_of_freedom: int
    selection: float | None

class _IndexRow(TypedDict):
    indices: list[int]
    order: int
    parameters: int
    ln_det: float | None
    aic: float | None
    mdl: float | None
    condition: float | None

class _BestIndices(TypedDict):
    aic: _IndexRow
    mdl: _IndexRow

class _Noise(TypedDict):
    variance: float
    standard_error: float | None
    at_limit: bool
    identifiable: bool | None

class _Gains(TypedDict):
    value: _Doubles
    standard_error: _Doubles
    low: _Doubles
    high: _Doubles

class _Estimate(TypedDict):
    value: float
    standard_error: float | None

class _Root(TypedDict):
    value: complex
    covariance: _Doubles | None
    standard_error: float | None
    magnitude: _Estimate
    time_constant_s: _Estimate | None
    damping: _Estimate | None
    natural_frequency_hz: _Estimate | None

class _Pole(_Root):
    output: str | None

class _Cancellation(TypedDict):
    pole: int
    zero: int
    distance: float
    standard_errors: float

class _ChannelZeros(TypedDict):
    output: str
    input: str
    zeros: list[_Root]
    cancellations: list[_Cancellation]

class _PoleZero(TypedDict):
    poles: list[_Pole]
    channels: list[_ChannelZeros]
    superfluous_poles: list[int]

class _Test(TypedDict):
    statistic: float
    degrees_of_freedom: float
    correction: float
    scale: float
    p_value: float

class _InputTests(TypedDict):
    output: str
    input: str
    independence: _Test | None
    feedback: _Test | None

class _OutputVerdict(TypedDict):
    output: str
    whiteness: _Outcome
    independence: _Outcome

class _ResidualVerdict(TypedDict):
    lags: int
    significance: float
    joint_whiteness: _Outcome
    outputs: list[_OutputVerdict]

class _Realisation(TypedDict):
    order: int
    reachable: int
    observable: int
    hankel_singular_values: list[float] | None
    minimal_order: int
    m_determinant: float
    m_condition: float | None
    warnings: list[dict[str, dict[str, float]]]

class _ConstrainedRow(TypedDict):
    output: str
    cost_ratio: float | None
    reflected_cost_ratio: float | None
    least_squares_radius: float
    radius: float
    active: list[dict[str, dict[str, Any]]]
    iterations: int

class _RefinedOutput(TypedDict):
    output: str
    accepted: bool
    train_before: float
    train_after: float
    hold_out_before: float | None
    hold_out_after: float | None
    radius: float
    iterations: int

class _SchedulePoint(TypedDict):
    value: float
    model: ArxModel

class _Alarm(TypedDict):
    time_s: float
    first_exceedance_s: float
    onset_s: float | None
    tag: str
    residual: float
    statistic: float
    threshold: float
    deviation: float | None
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
    mean_time: _MeanTime | None

class _MeanTime(TypedDict):
    asked_hours: float
    hours: float | None
    hours_low: float | None
    hours_high: float | None
    peaks: int
    healthy_hours: float
    healthy_hours_needed: float

class _ResidualTest(TypedDict):
    output: str
    outputs: list[str]
    poles: list[float]
    complex_poles: list[list[float]]
    statistic: dict[str, Any]
    whitening_order: int | None
    limit: float
    consecutive: int
    settle_samples: int
    false_alarms: _FalseAlarms

class _SimulatedRunLength(TypedDict):
    threshold: float
    samples: float
    low: float
    high: float
    alarms: int

class _EffectSignature(TypedDict):
    monitored: list[str]
    share: _Doubles
    strongest_case: list[int | None]
    most_affected: list[str | None]
    is_diagonal: bool

class _EffectReading(TypedDict):
    static_percent: _Doubles
    static_signature: _EffectSignature
    rms_percent: _Doubles
    rms_signature: _EffectSignature

class _FaultEffects(TypedDict):
    cases: list[str]
    outputs: list[str]
    units: list[str]
    steady: _Doubles
    raw: _EffectReading
    inputs_held: _EffectReading
    delivered_fuel_rms_percent: _Doubles

class _LagLimit(TypedDict):
    lag_s: float
    frequency_rad_s: float

_Feature: TypeAlias = Literal["plain"] | tuple[Literal["moving_mean", "high_pass"], float]

class _PeakGain(TypedDict):
    gain: float
    frequency_hz: float
    bound: float

class _Robustness(TypedDict):
    disturbance: _PeakGain
    fault: float
    fault_frequency_hz: float
    ratio: float

class _ChannelEstimates(TypedDict):
    u: _Doubles
    u_smoothed: _Doubles
    y: _Doubles

class _Innovation(TypedDict):
    value: _Doubles
    covariance: _Doubles
    normalised: _Doubles
    squared: float

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
    def trend(self) -> Trend: ...
    def detrended(self, trend: Trend) -> Dataset: ...
    def retrended(self, trend: Trend) -> Dataset: ...
    def __len__(self) -> int: ...
    def __getitem__(self, rows: slice, /) -> Dataset: ...
    def to_pandas(self) -> Any: ...
    def to_polars(self) -> Any: ...
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> Any: ...
    @staticmethod
    def from_pandas(
        frame: Any,
        inputs: _Names,
        outputs: _Names,
        sample_time_s: float | None = None,
        time: str | None = None,
    ) -> Dataset: ...
    @staticmethod
    def from_arrow(
        table: Any,
        inputs: _Names,
        outputs: _Names,
        sample_time_s: float | None = None,
        time: str | None = None,
    ) -> Dataset: ...

@final
class Trend:
    def __new__(
        cls, u_slope_per_s: Sequence[float], y_slope_per_s: Sequence[float], centre_time_s: float
    ) -> Trend: ...
    @property
    def u_slope_per_s(self) -> list[float]: ...
    @property
    def y_slope_per_s(self) -> list[float]: ...
    @property
    def centre_time_s(self) -> float: ...
    def __eq__(self, other: object, /) -> bool: ...

_Healthy: TypeAlias = Dataset | tuple[ArrayLike, ArrayLike]
_Record: TypeAlias = Dataset | ArrayLike | tuple[ArrayLike, ArrayLike]
_Records: TypeAlias = _Record | list[Dataset] | list[tuple[ArrayLike, ArrayLike]]

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
    def zeros(self) -> NDArray[np.complex128]: ...
    def simulate(self, u: ArrayLike, x0: ArrayLike | None = None) -> _Doubles: ...
    def markov_parameters(self, n: int) -> _Doubles: ...
    def to_json(self) -> str: ...
    @classmethod
    def from_json(cls, text: str) -> StateSpace: ...
    def to_control(self) -> Any: ...
    @classmethod
    def from_control(cls, system: Any) -> StateSpace: ...
    def to_scipy(self) -> Any: ...
    @classmethod
    def from_scipy(
        cls, system: Any, inputs: _Names | None = None, outputs: _Names | None = None
    ) -> StateSpace: ...

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
    @property
    def standard_errors(self) -> list[_Doubles] | None: ...
    def predict(self, u: _Record, y: ArrayLike | None = None) -> _Doubles: ...
    def equation_error(self, u: _Record, y: ArrayLike | None = None) -> _Doubles: ...
    def simulate(self, u: _Record, y: ArrayLike | None = None) -> FreeRun: ...
    def validate(self, u: _Record, y: ArrayLike | None = None) -> list[_OutputFit]: ...
    def test_residuals(
        self,
        u: _Record,
        y: ArrayLike | None = None,
        *,
        lags: int = 20,
        significance: float = 0.01,
        origin: Literal["fresh", "fitted"] = "fresh",
    ) -> ResidualReport: ...
    def realisation_report(self) -> _Realisation: ...
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
        order: _Order | None = None,
        na: int | None = None,
        nb: _Numbers | None = None,
        nk: _Numbers = 1,
        indices: Sequence[int] | None = None,
        structure: _Structure | None = None,
        first_row: int = 0,
        centre: _Centre = "means",
        missing: _Missing = "refuse",
        ridge: float = 0.0,
        equation_errors: _EquationErrors = "uncorrelated",
        solver: _Solver = "qr",
    ) -> Arx: ...
    def fit(
        self,
        u: _Records,
        y: ArrayLike | None = None,
        *,
        sample_time_s: float | None = None,
        inputs: _Names | None = None,
        outputs: _Names | None = None,
    ) -> ArxModel: ...
    def fit_in_full(
        self,
        u: _Records,
        y: ArrayLike | None = None,
        *,
        sample_time_s: float | None = None,
        inputs: _Names | None = None,
        outputs: _Names | None = None,
    ) -> ArxFit: ...

@final
class ArxFit:
    def __new__(
        cls,
        model: ArxModel,
        covariance: Sequence[ArrayLike],
        solved_by: Sequence[_SolvedBy] | None = None,
    ) -> ArxFit: ...
    @classmethod
    def from_record(
        cls, model: ArxModel, u: _Record, y: ArrayLike | None = None
    ) -> ArxFit: ...
    @property
    def model(self) -> ArxModel: ...
    @property
    def covariance(self) -> list[_Doubles]: ...
    @property
    def solved_by(self) -> list[_SolvedBy] | None: ...
    def frequency_response(self, frequencies_hz: ArrayLike) -> FrequencyResponse: ...
    def dc_gains(self, confidence: float = 0.95) -> _Gains: ...
    def pole_zero(self) -> _PoleZero: ...

@final
class FrequencyResponse:
    @property
    def inputs(self) -> list[str]: ...
    @property
    def outputs(self) -> list[str]: ...
    @property
    def frequency_hz(self) -> _Doubles: ...
    @property
    def response(self) -> NDArray[np.complex128]: ...
    @property
    def magnitude_error(self) -> _Doubles: ...
    @property
    def phase_error_rad(self) -> _Doubles: ...
    def magnitude_band(self, confidence: float = 0.95) -> _Doubles: ...
    def phase_band_rad(self, confidence: float = 0.95) -> _Doubles: ...

@final
class ResidualReport:
    @property
    def rows(self) -> int: ...
    @property
    def verdict(self) -> _ResidualVerdict: ...
    @property
    def autocorrelation(self) -> _Doubles: ...
    @property
    def autocorrelation_band(self) -> _Doubles: ...
    @property
    def cross_lags(self) -> NDArray[np.int64]: ...
    @property
    def cross_correlation(self) -> _Doubles: ...
    @property
    def cross_correlation_band(self) -> _Doubles: ...
    @property
    def ljung_box(self) -> list[_Test | None]: ...
    @property
    def hosking(self) -> _Test | None: ...
    @property
    def independence(self) -> list[_Test | None]: ...
    @property
    def by_input(self) -> list[_InputTests]: ...

@final
class EivModel:
    @property
    def kind(self) -> Literal["eiv", "frisch"]: ...
    @property
    def relation(self) -> ArxModel: ...
    @property
    def inputs(self) -> list[str]: ...
    @property
    def outputs(self) -> list[str]: ...
    @property
    def sample_time_s(self) -> float: ...
    @property
    def noise_variances(self) -> dict[str, float]: ...
    @property
    def noise(self) -> dict[str, _Noise]: ...
    @property
    def standard_errors(self) -> list[_Doubles] | None: ...
    @property
    def order_table(self) -> EivOrderTable | None: ...
    def save(self, path: _Path) -> None: ...
    @classmethod
    def load(cls, path: _Path) -> EivModel: ...
    def to_json(self) -> str: ...
    @classmethod
    def from_json(cls, text: str) -> EivModel: ...

@final
class EivOrderTable:
    @property
    def samples(self) -> int: ...
    @property
    def autoregression_order(self) -> int: ...
    @property
    def frequencies(self) -> int: ...
    @property
    def best(self) -> _BestEivOrder: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[_EivOrderRow]: ...
    def __getitem__(self, index: int, /) -> _EivOrderRow: ...

@final
class FrischOrderTable:
    @property
    def window_rows(self) -> int: ...
    @property
    def best(self) -> int | None: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[_FrischOrderRow]: ...
    def __getitem__(self, index: int, /) -> _FrischOrderRow: ...

@final
class IndexTable:
    @property
    def window_rows(self) -> int: ...
    @property
    def best(self) -> _BestIndices: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[_IndexRow]: ...
    def __getitem__(self, index: int, /) -> _IndexRow: ...

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
class ConstrainedArx:
    def __new__(
        cls,
        *,
        order: _Order | None = None,
        na: int | None = None,
        nb: _Numbers | None = None,
        nk: _Numbers = 1,
        max_radius: float = 0.999,
        dc_gains: Mapping[tuple[str, str], _Gain] | None = None,
    ) -> ConstrainedArx: ...
    def fit(
        self,
        u: _Record,
        y: ArrayLike | None = None,
        *,
        sample_time_s: float | None = None,
        inputs: _Names | None = None,
        outputs: _Names | None = None,
    ) -> ConstrainedFit: ...

@final
class ConstrainedFit:
    @property
    def model(self) -> ArxModel: ...
    @property
    def rows(self) -> list[_ConstrainedRow]: ...

@final
class OutputErrorRefinement:
    def __new__(
        cls,
        *,
        initial: Literal["estimated", "measured"] = "estimated",
        max_radius: float = 0.9999,
        max_iterations: int = 60,
    ) -> OutputErrorRefinement: ...
    def refine(self, model: ArxModel, train: _Healthy, hold_out: _Healthy) -> Refined: ...

@final
class Refined:
    @property
    def model(self) -> ArxModel: ...
    @property
    def outputs(self) -> list[_RefinedOutput]: ...

@final
class ScheduledArx:
    def __new__(
        cls,
        channel: str,
        values: Sequence[float],
        *,
        order: _Order | None = None,
        na: int | None = None,
        nb: _Numbers | None = None,
        nk: _Numbers = 1,
        indices: Sequence[int] | None = None,
        structure: _Structure | None = None,
        width: float = 1.0,
        estimation: Literal["local", "joint"] = "local",
    ) -> ScheduledArx: ...
    def fit(
        self,
        u: _Records,
        y: ArrayLike | None = None,
        *,
        sample_time_s: float | None = None,
        inputs: _Names | None = None,
        outputs: _Names | None = None,
    ) -> ScheduledModel: ...

class _ScheduledRun(TypedDict):
    residuals: _Doubles
    weights: _Doubles

@final
class ScheduledGenerators:
    def __new__(
        cls,
        channel: str,
        points: Sequence[tuple[float, Observer | KalmanFilter]],
        hysteresis: float | None = None,
    ) -> ScheduledGenerators: ...
    def run(self, data: Dataset) -> _ScheduledRun: ...
    def residuals(self, data: Dataset) -> _Doubles: ...
    def weights(self, value: float) -> _Doubles: ...
    @property
    def channel(self) -> str: ...
    @property
    def breakpoints(self) -> _Doubles: ...
    @property
    def hysteresis(self) -> float | None: ...
    @property
    def settle_samples(self) -> int: ...
    def to_json(self) -> str: ...
    @classmethod
    def from_json(cls, text: str) -> ScheduledGenerators: ...

@final
class ScheduledModel:
    def __new__(
        cls, channel: str, points: Sequence[tuple[float, ArxModel]], width: float = 1.0
    ) -> ScheduledModel: ...
    @property
    def channel(self) -> str: ...
    @property
    def width(self) -> float: ...
    @property
    def points(self) -> list[_SchedulePoint]: ...
    @property
    def inputs(self) -> list[str]: ...
    @property
    def outputs(self) -> list[str]: ...
    @property
    def sample_time_s(self) -> float: ...
    @property
    def max_lag(self) -> int: ...
    def predict(self, u: _Record, y: ArrayLike | None = None) -> _Doubles: ...
    def simulate(self, u: _Record, y: ArrayLike | None = None) -> FreeRun: ...
    def to_json(self) -> str: ...
    @classmethod
    def from_json(cls, text: str) -> ScheduledModel: ...

@final
class Observer:
    def residual(self, u: _Record, y: ArrayLike | None = None) -> _Doubles: ...
    @property
    def gain(self) -> _Doubles: ...
    @property
    def poles(self) -> _Doubles | NDArray[np.complex128]: ...
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
class ObserverDesign:
    @property
    def poles(self) -> NDArray[np.complex128]: ...
    @property
    def observer(self) -> Observer: ...
    @property
    def criterion(self) -> Literal["fault-energy", "paper"]: ...
    @property
    def radius(self) -> float: ...
    @property
    def v(self) -> float: ...
    @property
    def v_validation(self) -> float | None: ...
    @property
    def bound(self) -> float: ...
    @property
    def bound_validation(self) -> float | None: ...
    @property
    def evaluations(self) -> int: ...
    @property
    def start(self) -> dict[str, Any]: ...
    @property
    def attempts(self) -> list[dict[str, Any]]: ...
    def to_json(self) -> str: ...
    @classmethod
    def from_json(cls, text: str) -> ObserverDesign: ...

@final
class KalmanFilter:
    def innovations(self, u: _Record, y: ArrayLike | None = None) -> _Doubles: ...
    def run(
        self, u: _Record, y: ArrayLike | None = None, x0: ArrayLike | None = None
    ) -> FilterRun: ...
    @property
    def noise(self) -> NoiseCovariance: ...
    @property
    def predictor_gain(self) -> _Doubles: ...
    @property
    def filter_gain(self) -> _Doubles: ...
    @property
    def innovation_covariance(self) -> _Doubles: ...
    @property
    def predicted_covariance(self) -> _Doubles: ...
    @property
    def filtered_covariance(self) -> _Doubles: ...
    @property
    def spectral_radius(self) -> float: ...
    @property
    def settle_samples(self) -> int: ...
    @property
    def model(self) -> StateSpace: ...
    @property
    def point(self) -> _Point: ...
    def to_json(self) -> str: ...
    @classmethod
    def from_json(cls, text: str) -> KalmanFilter: ...

@final
class NoiseCovariance:
    def __new__(cls, Q: ArrayLike, R: ArrayLike, S: ArrayLike | None = None) -> NoiseCovariance: ...
    @classmethod
    def errors_in_variables(
        cls,
        model: StateSpace | OutputModel,
        input_variances: ArrayLike,
        output_variances: ArrayLike,
    ) -> NoiseCovariance: ...
    @property
    def Q(self) -> _Doubles: ...
    @property
    def R(self) -> _Doubles: ...
    @property
    def S(self) -> _Doubles: ...

@final
class FilterRun:
    @property
    def innovations(self) -> _Doubles: ...
    @property
    def normalised(self) -> _Doubles: ...
    @property
    def predicted(self) -> _Doubles: ...
    @property
    def filtered(self) -> _Doubles: ...
    def __len__(self) -> int: ...

@final
class EivKalman:
    def __new__(
        cls,
        model: StateSpace | OutputModel,
        input_variances: ArrayLike,
        output_variances: ArrayLike,
        point: tuple[ArrayLike, ArrayLike] | None = None,
    ) -> EivKalman: ...
    def run(
        self, u: _Record, y: ArrayLike | None = None, x0: ArrayLike | None = None
    ) -> FilterRun: ...
    def estimate(
        self, u: _Record, y: ArrayLike | None = None, x0: ArrayLike | None = None
    ) -> _ChannelEstimates: ...
    @property
    def output_error_covariance(self) -> _Doubles: ...
    @property
    def input_error_covariance(self) -> _Doubles: ...
    @property
    def smoothed_input_error_covariance(self) -> _Doubles: ...
    @property
    def predictor_gain(self) -> _Doubles: ...
    @property
    def filter_gain(self) -> _Doubles: ...
    @property
    def innovation_covariance(self) -> _Doubles: ...
    @property
    def model(self) -> StateSpace: ...
    @property
    def point(self) -> _Point: ...

@final
class TimeVaryingKalman:
    def __new__(
        cls,
        model: StateSpace | OutputModel,
        noise: NoiseCovariance,
        P0: ArrayLike,
        x0: ArrayLike | None = None,
        point: tuple[ArrayLike, ArrayLike] | None = None,
    ) -> TimeVaryingKalman: ...
    def step(self, u: ArrayLike, y: ArrayLike) -> _Innovation: ...
    def process(self, u: _Record, y: ArrayLike | None = None) -> _Doubles: ...
    def reset(self) -> None: ...
    @property
    def state(self) -> _Doubles: ...
    @property
    def covariance(self) -> _Doubles: ...
    @property
    def predictor_gain(self) -> _Doubles: ...
    @property
    def filter_gain(self) -> _Doubles: ...
    @property
    def model(self) -> StateSpace: ...
    @property
    def noise(self) -> NoiseCovariance: ...
    @property
    def point(self) -> _Point: ...

@final
class FaultModel:
    def __new__(
        cls,
        model: StateSpace | OutputModel,
        *,
        E_d: ArrayLike | None = None,
        F_d: ArrayLike | None = None,
        E_f: ArrayLike | None = None,
        F_f: ArrayLike | None = None,
        point: tuple[ArrayLike, ArrayLike] | None = None,
    ) -> FaultModel: ...
    @property
    def model(self) -> StateSpace: ...
    @property
    def E_d(self) -> _Doubles: ...
    @property
    def F_d(self) -> _Doubles: ...
    @property
    def E_f(self) -> _Doubles: ...
    @property
    def F_f(self) -> _Doubles: ...
    @property
    def point(self) -> _Point: ...

@final
class LinearResidual:
    def __new__(
        cls, system: StateSpace, point: tuple[ArrayLike, ArrayLike]
    ) -> LinearResidual: ...
    def residuals(self, u: _Record, y: ArrayLike | None = None) -> _Doubles: ...
    @property
    def system(self) -> StateSpace: ...
    @property
    def point(self) -> _Point: ...
    @property
    def inputs(self) -> list[str]: ...
    @property
    def outputs(self) -> list[str]: ...
    @property
    def residual_names(self) -> list[str]: ...
    @property
    def settle_samples(self) -> int: ...
    def to_json(self) -> str: ...
    @classmethod
    def from_json(cls, text: str) -> LinearResidual: ...

@final
class UnknownInputObserver:
    def __new__(
        cls,
        model: FaultModel,
        *,
        noise: NoiseCovariance | None = None,
        poles: Sequence[float] | None = None,
    ) -> UnknownInputObserver: ...
    def residuals(self, u: _Record, y: ArrayLike | None = None) -> _Doubles: ...
    @property
    def linear_residual(self) -> LinearResidual: ...
    @property
    def from_disturbance(self) -> StateSpace: ...
    @property
    def from_fault(self) -> StateSpace: ...
    @property
    def gain(self) -> _Doubles: ...
    @property
    def covariance(self) -> _Doubles | None: ...
    @property
    def settle_samples(self) -> int: ...
    @property
    def model(self) -> FaultModel: ...

@final
class UnifiedFilter:
    def __new__(cls, model: FaultModel) -> UnifiedFilter: ...
    def residuals(self, u: _Record, y: ArrayLike | None = None) -> _Doubles: ...
    def robustness(self, band_hz: tuple[float, float] | None = None) -> _Robustness: ...
    @property
    def linear_residual(self) -> LinearResidual: ...
    @property
    def kalman(self) -> KalmanFilter: ...
    @property
    def post_filter(self) -> _Doubles: ...
    @property
    def from_disturbance(self) -> StateSpace: ...
    @property
    def from_fault(self) -> StateSpace: ...
    @property
    def settle_samples(self) -> int: ...
    @property
    def model(self) -> FaultModel: ...

@final
class Detection:
    @property
    def time_s(self) -> _Doubles: ...
    @property
    def outputs(self) -> list[str]: ...
    @property
    def residuals(self) -> _Doubles: ...
    @property
    def tests(self) -> list[str]: ...
    @property
    def statistics(self) -> _Doubles: ...
    @property
    def alarms(self) -> list[_Alarm]: ...
    @property
    def share_above_limit(self) -> _Doubles: ...
    def to_pandas(self) -> Any: ...
    def to_polars(self) -> Any: ...
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> Any: ...

class _FaultHypothesis(TypedDict):
    fault: str
    unit: str
    probability: float
    magnitude: float
    magnitude_interval: list[float]
    onset_s: float
    onset_interval_s: list[float]

class _FaultPair(TypedDict):
    faults: list[str]
    probability: float
    magnitudes: list[float]
    onsets_s: list[float]

class _Diagnosis(TypedDict):
    diagnosed_s: float
    finding: str
    fault: str | None
    unit: str | None
    probability: float | None
    onset_s: float | None
    magnitude: float | None
    hypotheses: list[_FaultHypothesis]
    none_of_these: float
    pair: _FaultPair | None

class _IsolationAlarm(_Diagnosis):
    time_s: float
    end_s: float | None
    tag: str
    statistic: float
    threshold: float
    named_s: float | None

@final
class Isolation:
    @property
    def alarms(self) -> list[_IsolationAlarm]: ...
    @property
    def judged(self) -> int: ...
    @property
    def peaks(self) -> _Doubles: ...

@final
class IsolationMonitor:
    def step(self, u: ArrayLike, y: ArrayLike, t_s: float | None = None) -> list[str]: ...
    def state(self) -> str: ...
    def resume(self, state: str) -> None: ...
    @property
    def statistics(self) -> _Doubles: ...
    @property
    def alarm(self) -> bool: ...
    @property
    def settling(self) -> bool: ...
    @property
    def diagnosis(self) -> _Diagnosis | None: ...

@final
class Isolator:
    @property
    def name(self) -> str: ...
    @property
    def inputs(self) -> list[str]: ...
    @property
    def outputs(self) -> list[str]: ...
    @property
    def sample_time_s(self) -> float: ...
    @property
    def settle_samples(self) -> int: ...
    @property
    def hypotheses(self) -> list[dict[str, Any]]: ...
    @property
    def statistics(self) -> list[str]: ...
    @property
    def limits(self) -> _Doubles: ...
    @property
    def mean_times(self) -> list[_MeanTime]: ...
    def detect(self, u: _Record, y: ArrayLike | None = None) -> Isolation: ...
    def write_diagnoses(
        self, path: _Path, u: _Record, y: ArrayLike | None = None
    ) -> None: ...
    def monitor(self) -> IsolationMonitor: ...
    def save(self, path: _Path) -> None: ...
    @classmethod
    def load(cls, path: _Path) -> Isolator: ...
    def to_json(self) -> str: ...
    @classmethod
    def from_json(cls, text: str) -> Isolator: ...

@final
class Bank:
    @property
    def name(self) -> str: ...
    @property
    def inputs(self) -> list[str]: ...
    @property
    def outputs(self) -> list[str]: ...
    @property
    def output_units(self) -> list[str]: ...
    @property
    def sample_time_s(self) -> float: ...
    @property
    def tests(self) -> list[str]: ...
    @property
    def false_alarms_per_hour(self) -> _FalseAlarmRate: ...
    @property
    def detectors(self) -> list[_ResidualTest]: ...
    def detect(self, u: _Record, y: ArrayLike | None = None) -> Detection: ...
    def write_verdicts(
        self, path: _Path, u: _Record, y: ArrayLike | None = None
    ) -> None: ...
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
    def tests(self) -> list[str]: ...
    @property
    def sample_time_s(self) -> float: ...
    def state(self) -> str: ...
    def resume(self, state: str) -> None: ...
    def step(self, u: ArrayLike, y: ArrayLike, t_s: float | None = None) -> Verdict: ...
    def process(
        self, u: _Record, y: ArrayLike | None = None, t_s: float | None = None
    ) -> VerdictSeries: ...
    def reset(self) -> None: ...

@final
class Verdict:
    @property
    def tests(self) -> list[str]: ...
    @property
    def time_s(self) -> float: ...
    @property
    def gap(self) -> bool: ...
    @property
    def residual(self) -> _Doubles: ...
    @property
    def statistic(self) -> _Doubles: ...
    @property
    def deviation(self) -> _Doubles: ...
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
    def tests(self) -> list[str]: ...
    @property
    def time_s(self) -> _Doubles: ...
    @property
    def gap(self) -> _Flags: ...
    @property
    def residual(self) -> _Doubles: ...
    @property
    def statistic(self) -> _Doubles: ...
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
    def to_pandas(self) -> Any: ...
    def to_polars(self) -> Any: ...
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> Any: ...

_Sides: TypeAlias = Literal["upper", "lower", "both"]
_Waveform: TypeAlias = Literal["step", "ramp"]

@final
class Fleet:
    def __new__(cls, generator: Observer | KalmanFilter, streams: int) -> Fleet: ...
    @property
    def inputs(self) -> list[str]: ...
    @property
    def outputs(self) -> list[str]: ...
    @property
    def streams(self) -> int: ...
    def process(self, u: ArrayLike, y: ArrayLike) -> _Doubles: ...
    def reset(self) -> None: ...

@final
class SignatureMatrix:
    @property
    def faults(self) -> list[str]: ...
    @property
    def residuals(self) -> list[str]: ...
    @property
    def matrix(self) -> _Doubles: ...
    @property
    def raw(self) -> _Doubles: ...
    @property
    def definition(self) -> str: ...
    @property
    def is_diagonal(self) -> bool: ...

@final
class Riccati:
    @property
    def P(self) -> _Doubles: ...
    @property
    def relative_residual(self) -> float: ...
    @property
    def spectral_radius(self) -> float: ...
    @property
    def iterations(self) -> int: ...

@final
class Cusum:
    def __new__(
        cls, allowance: float, threshold: float, sides: _Sides = "both"
    ) -> Cusum: ...
    def step(self, residual: float) -> tuple[float, bool, bool]: ...
    def process(self, residuals: ArrayLike) -> _Doubles: ...
    def reset(self) -> None: ...
    @property
    def value(self) -> float: ...
    @property
    def threshold(self) -> float: ...
    @property
    def allowance(self) -> float: ...
    @property
    def upper(self) -> float: ...
    @property
    def lower(self) -> float: ...
    @property
    def change(self) -> tuple[int, float] | None: ...

@final
class CusumFleet:
    def __new__(cls, cusum: Cusum, streams: int) -> CusumFleet: ...
    @property
    def streams(self) -> int: ...
    @property
    def threshold(self) -> float: ...
    def process(self, residuals: ArrayLike) -> _Doubles: ...
    def reset(self) -> None: ...

@final
class ShiryaevRoberts:
    def __new__(
        cls, shift: float, threshold: float, sides: _Sides = "both"
    ) -> ShiryaevRoberts: ...
    def step(self, residual: float) -> tuple[float, bool, bool]: ...
    def process(self, residuals: ArrayLike) -> _Doubles: ...
    def reset(self) -> None: ...
    @property
    def value(self) -> float: ...
    @property
    def threshold(self) -> float: ...
    @property
    def upper(self) -> float: ...
    @property
    def lower(self) -> float: ...

@final
class Glr:
    def __new__(
        cls, waveform: _Waveform, sizes: tuple[float, float], threshold: float,
        longest: int = 4096, sides: _Sides = "both"
    ) -> Glr: ...
    def step(self, residual: float) -> tuple[float, bool, bool]: ...
    def process(self, residuals: ArrayLike) -> _Doubles: ...
    def reset(self) -> None: ...
    @property
    def value(self) -> float: ...
    @property
    def threshold(self) -> float: ...
    @property
    def change(self) -> tuple[int, float] | None: ...

@final
class MovingAverage:
    def __new__(
        cls, window: int, threshold: float, sides: _Sides = "both"
    ) -> MovingAverage: ...
    def step(self, residual: float) -> tuple[float, bool, bool]: ...
    def process(self, residuals: ArrayLike) -> _Doubles: ...
    def reset(self) -> None: ...
    @property
    def value(self) -> float: ...
    @property
    def threshold(self) -> float: ...
    @property
    def window(self) -> int: ...
    @property
    def mean(self) -> float: ...

@final
class RunSum:
    def __new__(
        cls, width: float, scores: Sequence[int] = (0, 2, 4, 8),
        threshold: float = 7.0, sides: _Sides = "both"
    ) -> RunSum: ...
    def step(self, residual: float) -> tuple[float, bool, bool]: ...
    def process(self, residuals: ArrayLike) -> _Doubles: ...
    def reset(self) -> None: ...
    @property
    def value(self) -> float: ...
    @property
    def threshold(self) -> float: ...
    @property
    def upper(self) -> int: ...
    @property
    def lower(self) -> int: ...

@final
class Sprt:
    def __new__(
        cls, shift: float, accept: float, reject: float
    ) -> Sprt: ...
    def step(self, residual: float) -> tuple[float, bool, bool]: ...
    def process(self, residuals: ArrayLike) -> _Doubles: ...
    def reset(self) -> None: ...
    @property
    def value(self) -> float: ...
    @property
    def threshold(self) -> float: ...
    @property
    def decision(self) -> Literal["undecided", "healthy", "faulty"]: ...

@final
class WindowedChiSquare:
    def __new__(
        cls, window: int, threshold: float
    ) -> WindowedChiSquare: ...
    def step(self, residual: float) -> tuple[float, bool, bool]: ...
    def process(self, residuals: ArrayLike) -> _Doubles: ...
    def reset(self) -> None: ...
    @property
    def value(self) -> float: ...
    @property
    def threshold(self) -> float: ...
    @property
    def window(self) -> int: ...

@final
class WindowedVariance:
    def __new__(
        cls, window: int, threshold: float, sides: _Sides = "both"
    ) -> WindowedVariance: ...
    def step(self, residual: float) -> tuple[float, bool, bool]: ...
    def process(self, residuals: ArrayLike) -> _Doubles: ...
    def reset(self) -> None: ...
    @property
    def value(self) -> float: ...
    @property
    def threshold(self) -> float: ...
    @property
    def window(self) -> int: ...
    @property
    def variance(self) -> float | None: ...

@final
class Whiteness:
    def __new__(
        cls, window: int, lags: int, threshold: float
    ) -> Whiteness: ...
    def step(self, residual: float) -> tuple[float, bool, bool]: ...
    def process(self, residuals: ArrayLike) -> _Doubles: ...
    def reset(self) -> None: ...
    @property
    def value(self) -> float: ...
    @property
    def threshold(self) -> float: ...
    @property
    def window(self) -> int: ...
    @property
    def lags(self) -> int: ...
    @property
    def correlations(self) -> _Doubles: ...

@final
class GrowingChiSquare:
    def __new__(
        cls, shortest: int, threshold: float, longest: int | None = None,
        sides: _Sides = "upper"
    ) -> GrowingChiSquare: ...
    def step(self, residual: float) -> tuple[float, bool, bool]: ...
    def process(self, residuals: ArrayLike) -> _Doubles: ...
    def reset(self) -> None: ...
    @property
    def value(self) -> float: ...
    @property
    def threshold(self) -> float: ...
    @property
    def count(self) -> int: ...
    @property
    def sum(self) -> float: ...

@final
class GrowingVariance:
    def __new__(
        cls, shortest: int, threshold: float, longest: int | None = None,
        sides: _Sides = "both"
    ) -> GrowingVariance: ...
    def step(self, residual: float) -> tuple[float, bool, bool]: ...
    def process(self, residuals: ArrayLike) -> _Doubles: ...
    def reset(self) -> None: ...
    @property
    def value(self) -> float: ...
    @property
    def threshold(self) -> float: ...
    @property
    def count(self) -> int: ...
    @property
    def mean(self) -> float: ...
    @property
    def variance(self) -> float | None: ...

@final
class AdaptiveThreshold:
    def __new__(
        cls, base: float, gains: ArrayLike, time_constant: float
    ) -> AdaptiveThreshold: ...
    def step(self, u: ArrayLike, residual: float) -> tuple[float, bool, bool]: ...
    def reset(self) -> None: ...
    @property
    def value(self) -> float: ...
    @property
    def limit(self) -> float: ...

_Statistic: TypeAlias = (
    Cusum
    | ShiryaevRoberts
    | Glr
    | MovingAverage
    | RunSum
    | Sprt
    | WindowedChiSquare
    | WindowedVariance
    | Whiteness
    | GrowingChiSquare
    | GrowingVariance
)

@final
class SimulatedRuns:
    def __new__(
        cls,
        statistic: _Statistic,
        noise: Callable[[int], ArrayLike],
        paths: int,
        samples: int,
    ) -> SimulatedRuns: ...
    def run_length(self, threshold: float) -> _SimulatedRunLength: ...
    def threshold_for(self, run_length: float) -> _SimulatedRunLength: ...

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
def write_report(
    folder: _Path,
    subject: Bank | Isolator | ArxFit | ArxModel | EivModel,
    u: _Record,
    y: ArrayLike | None = None,
    *,
    orders: OrderTable | EivOrderTable | None = None,
) -> None: ...
def read(
    path: _Path,
    *,
    inputs: _Names,
    outputs: _Names,
    time: str | None = None,
    sample_time_s: float | None = None,
    topic: str | None = None,
    rows: tuple[int, int] | None = None,
    missing: _Missing = "refuse",
    encoding: str | None = None,
    decimal: Literal["point", "comma"] | None = None,
    header_line: int | None = None,
    bad_values: _Names | None = None,
    time_zone: str | None = None,
    time_format: str | None = None,
    layout: Literal["wide", "long"] | None = None,
    resample_s: float | None = None,
    resample_method: Literal["mean", "hold", "linear"] | None = None,
    hold_at_most_s: float | None = None,
    tags: _Path | None = None,
) -> Dataset: ...
def check(
    path: _Path,
    *,
    inputs: _Names | None = None,
    outputs: _Names | None = None,
    time: str | None = None,
    sample_time_s: float | None = None,
    topic: str | None = None,
    encoding: str | None = None,
    decimal: Literal["point", "comma"] | None = None,
    header_line: int | None = None,
    bad_values: _Names | None = None,
    time_zone: str | None = None,
    time_format: str | None = None,
    layout: Literal["wide", "long"] | None = None,
    resample_s: float | None = None,
    resample_method: Literal["mean", "hold", "linear"] | None = None,
    hold_at_most_s: float | None = None,
    tags: _Path | None = None,
) -> dict[str, Any]: ...
def fault_effects(
    map_set: Literal["paper", "axial"] = "paper",
    *,
    flow_loss_percent: float = 5.0,
    drift_percent: float = 5.0,
    efficiency_loss_percent: float = 5.0,
    lag_s: float = 2.0,
    profile: str = "lively",
    window_s: float = 120.0,
    settle_s: float = 30.0,
    substeps: int = 28,
    seed: int = 0,
    run_index: int = 0,
) -> _FaultEffects: ...
def lag_limit(map_set: Literal["paper", "axial"] = "paper") -> _LagLimit | None: ...
def signature(
    faulty: dict[str, Any],
    healthy: ArrayLike,
    sample_time_s: float,
    *,
    window: tuple[int, int] | None = None,
    features: _Feature | Sequence[_Feature] = "plain",
    residuals: _Names | None = None,
) -> SignatureMatrix: ...
def feature(
    series: ArrayLike,
    sample_time_s: float,
    kind: Literal["moving_mean", "high_pass", "plain"],
    window_s: float | None = None,
) -> _Doubles: ...
def arx(
    u: _Records,
    y: ArrayLike | None = None,
    *,
    order: _Order | None = None,
    na: int | None = None,
    nb: _Numbers | None = None,
    nk: _Numbers = 1,
    indices: Sequence[int] | None = None,
    structure: _Structure | None = None,
    first_row: int = 0,
    centre: _Centre = "means",
    missing: _Missing = "refuse",
    ridge: float = 0.0,
    equation_errors: _EquationErrors = "uncorrelated",
    solver: _Solver = "qr",
    sample_time_s: float | None = None,
    inputs: _Names | None = None,
    outputs: _Names | None = None,
) -> ArxModel: ...
def eiv(
    u: _Record,
    y: ArrayLike | None = None,
    *,
    order: _Order,
    nk: _Numbers = 1,
    autoregression_order: int | None = None,
    frequencies: int | None = None,
    pole_prior: float = 0.0,
    sample_time_s: float | None = None,
    inputs: _Names | None = None,
    outputs: _Names | None = None,
) -> EivModel: ...
def frisch(
    u: _Record,
    y: ArrayLike | None = None,
    *,
    order: _Order,
    nk: _Numbers = 1,
    criterion: Literal["yule-walker", "covariance", "shift"] = "yule-walker",
    sample_time_s: float | None = None,
    inputs: _Names | None = None,
    outputs: _Names | None = None,
) -> EivModel: ...
def eiv_order_table(
    u: _Record,
    y: ArrayLike | None = None,
    orders: tuple[int, int] = (1, 6),
    *,
    nk: _Numbers = 1,
    sample_time_s: float | None = None,
    inputs: _Names | None = None,
    outputs: _Names | None = None,
) -> EivOrderTable: ...
def frisch_order_table(
    u: _Record,
    y: ArrayLike | None = None,
    orders: tuple[int, int] = (1, 6),
    *,
    output: int | str = 0,
    nk: _Numbers = 1,
    sample_time_s: float | None = None,
    inputs: _Names | None = None,
    outputs: _Names | None = None,
) -> FrischOrderTable: ...
def index_table(
    u: _Record,
    y: ArrayLike | None = None,
    *,
    orders: tuple[int, int],
    spread: int = 1,
    feedthrough: bool = False,
    sample_time_s: float | None = None,
    inputs: _Names | None = None,
    outputs: _Names | None = None,
) -> IndexTable: ...
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
def optimise_observer(
    model: StateSpace | OutputModel,
    pairs: Sequence[tuple[_Healthy, _Healthy]],
    validation: Sequence[tuple[_Healthy, _Healthy]] = (),
    *,
    criterion: Literal["fault-energy", "paper"] = "fault-energy",
    method: Literal["descent", "evolution"] = "descent",
    radius: float = 0.97,
    skip_samples: int = 0,
    diagonal_starts: int = 9,
    random_starts: int = 20,
    seed: int = 0,
    bound_pole: float = 0.9,
    bound_functions: int = 8,
    point: tuple[ArrayLike, ArrayLike] | None = None,
) -> ObserverDesign: ...
def kalman(
    model: StateSpace | OutputModel,
    input_variances: ArrayLike | None = None,
    output_variances: ArrayLike | None = None,
    point: tuple[ArrayLike, ArrayLike] | None = None,
    *,
    noise: NoiseCovariance | None = None,
) -> KalmanFilter: ...
def peak_gain(system: StateSpace) -> _PeakGain: ...
def robustness(
    from_disturbance: StateSpace,
    from_fault: StateSpace,
    band_hz: tuple[float, float] | None = None,
) -> _Robustness: ...
def design(
    model: ArxModel | EivModel,
    healthy: Sequence[_Healthy],
    *,
    generator: str = "observer",
    statistic: str = "threshold",
    watch: str = "outputs",
    unknown: Sequence[str] | None = None,
    poles: _Poles | Mapping[str, _Poles] | None = None,
    window: int | None = None,
    allowance: float | None = None,
    waveform: str | None = None,
    sizes: tuple[float, float] | None = None,
    exceedance: float | None = None,
    margin: float | None = None,
    arl0_h: float | None = None,
    consecutive: int | None = None,
    in_sample: bool = False,
) -> Bank: ...
def design_isolator(
    model: ArxModel | EivModel,
    healthy: Sequence[_Healthy],
    faults: Sequence[Mapping[str, Any]],
    *,
    generator: str = "kalman",
    poles: _Poles | Mapping[str, _Poles] | None = None,
    arl0_h: float = 24.0,
    confidence: float = 0.99,
    longest_s: float = 600.0,
    limiter: float | None = None,
    half_width: int | None = None,
) -> Isolator: ...
def linearise(
    variant: Literal["prototype", "cogeneration"] = "prototype",
    map_set: Literal["paper", "axial"] = "paper",
    loop: Literal["closed", "open"] = "closed",
) -> StateSpace: ...
def place(model: StateSpace, poles: _Poles, radius: float = 0.0) -> _Doubles: ...
def riccati(
    A: ArrayLike, C: ArrayLike, Q: ArrayLike, R: ArrayLike, S: ArrayLike | None = None
) -> Riccati: ...
def cusum_run_length(
    allowance: float, threshold: float, shift: float = 0.0, sides: _Sides = "both"
) -> float: ...
def cusum_threshold(allowance: float, run_length: float, sides: _Sides = "both") -> float: ...
def exceedance_run_length(
    limit: float, consecutive: int = 1, shift: float = 0.0, sides: _Sides = "both"
) -> float: ...
def exceedance_limit(
    run_length: float, consecutive: int = 1, sides: _Sides = "both"
) -> float: ...
def run_sum_run_length(
    width: float,
    scores: Sequence[int] = (0, 2, 4, 8),
    threshold: int = 7,
    shift: float = 0.0,
    sides: _Sides = "both",
) -> float: ...
def run_sum_width(
    run_length: float,
    scores: Sequence[int] = (0, 2, 4, 8),
    threshold: int = 7,
    sides: _Sides = "both",
) -> float: ...
def shiryaev_roberts_run_length(
    shift: float, threshold: float, mean: float = 0.0
) -> float: ...
def shiryaev_roberts_threshold(shift: float, run_length: float) -> float: ...
def mean_delay_bound(waveform: _Waveform, size: float, run_length: float) -> float: ...
def reproduce(folder: _Path, *, seed: int = 1, full: bool = False) -> dict[str, Any]: ...
def log_info(path: _Path) -> dict[str, Any]: ...
def log_attachment(path: _Path, name: str) -> bytes: ...
def log_messages(path: _Path, topic: str) -> list[dict[str, Any]]: ...
def log_verify(path: _Path) -> dict[str, Any]: ...
def log_recover(path: _Path, out: _Path) -> dict[str, Any]: ...
def log_export(
    path: _Path,
    out: _Path,
    topic: str | None = None,
    tags: _Names | None = None,
    rows: tuple[int, int] | None = None,
    time: Literal["iso", "seconds"] = "iso",
) -> dict[str, Any]: ...
@final
class _CampaignDesk:
    def __new__(cls, spec: _Path, out: _Path) -> _CampaignDesk: ...
    @property
    def runs(self) -> int: ...
    def missing(self) -> list[int]: ...
    def runs_of(self, chunk: int) -> tuple[int, int]: ...
    def task(self) -> _CampaignTask: ...
    def keep(self, chunk: int, sha256: str, bytes: bytes) -> None: ...
    def finish(self) -> dict[str, Any]: ...
    def close(self) -> None: ...

@final
class _CampaignTask:
    def __new__(cls, version: str, text: str) -> _CampaignTask: ...
    def parts(self, chunks: Sequence[int]) -> list[tuple[int, str, bytes]]: ...
    def __reduce__(self) -> tuple[type[_CampaignTask], tuple[str, str]]: ...

def campaign_run(spec: _Path, out: _Path) -> dict[str, Any]: ...
def campaign_rows(
    spec: _Path, runs: Sequence[int], out: _Path | None = None
) -> list[dict[str, Any]]: ...
def campaign_compare(folders: Sequence[_Path], out: _Path) -> dict[str, Any]: ...
def _restore(name: str, form: int, version: str, digest: str, payload: bytes) -> Any: ...
