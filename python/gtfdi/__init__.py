"""Model-based fault diagnosis for turbines and any plant with measured inputs and outputs.

A record becomes a model, a model a bank of observers, a bank verdicts::

    import gtfdi

    healthy = gtfdi.simulate(600.0, seed=1).measured
    model = gtfdi.arx(healthy, order=8, nk=0, inputs=["a_v", "M_f"], outputs=["q_c"])
    bank = gtfdi.design(model, [healthy], poles=0.7, margin=1.2)

    fouling = {"case": "compressor_fouling", "onset_s": 60.0, "rate_percent_per_h": 5.0}
    alarms = bank.detect(gtfdi.simulate(600.0, seed=2, faults=[fouling]).measured).alarms

Time is axis 0: arrays are ``(samples, channels)``, or ``(samples,)`` for one channel. A
C-contiguous float64 array is read where it is, and copied once into what keeps it; anything else
is converted first. Units are SI. ``predict`` is one step ahead, ``simulate`` is a free run.
"""

from gtfdi.errors import (
    ArrayTypeError,
    DataError,
    DesignError,
    DimensionError,
    GtfdiError,
    IdentError,
    LogError,
    ModelError,
    OptionError,
    PlantError,
    StepError,
)
from gtfdi._gtfdi import (
    Arx,
    ArxFit,
    ArxModel,
    Bank,
    ConstrainedArx,
    ConstrainedFit,
    Dataset,
    Detection,
    Detector,
    EivModel,
    EivOrderTable,
    FreeRun,
    FrequencyResponse,
    FrischOrderTable,
    IndexTable,
    Observer,
    OrderTable,
    OutputErrorRefinement,
    OutputModel,
    Refined,
    ResidualReport,
    Run,
    ScheduledArx,
    ScheduledModel,
    StateSpace,
    Verdict,
    VerdictSeries,
    __version__,
    arx,
    design,
    eiv,
    eiv_order_table,
    frisch,
    frisch_order_table,
    index_table,
    observer,
    order_table,
    read,
    simulate,
    steady_state,
    units,
)

__all__ = [
    "ArrayTypeError",
    "Arx",
    "ArxFit",
    "ArxModel",
    "Bank",
    "ConstrainedArx",
    "ConstrainedFit",
    "DataError",
    "Dataset",
    "DesignError",
    "Detection",
    "Detector",
    "DimensionError",
    "EivModel",
    "EivOrderTable",
    "FreeRun",
    "FrequencyResponse",
    "FrischOrderTable",
    "GtfdiError",
    "IdentError",
    "IndexTable",
    "LogError",
    "ModelError",
    "Observer",
    "OptionError",
    "OrderTable",
    "OutputErrorRefinement",
    "OutputModel",
    "PlantError",
    "Refined",
    "ResidualReport",
    "Run",
    "ScheduledArx",
    "ScheduledModel",
    "StateSpace",
    "StepError",
    "Verdict",
    "VerdictSeries",
    "__version__",
    "arx",
    "design",
    "eiv",
    "eiv_order_table",
    "frisch",
    "frisch_order_table",
    "index_table",
    "observer",
    "order_table",
    "read",
    "simulate",
    "steady_state",
    "units",
]
