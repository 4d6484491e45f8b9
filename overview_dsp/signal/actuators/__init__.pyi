"""Public names of `ov.actuators`, each imported when it is first used."""

from overview_dsp.signal.actuators.calibration import (
    apply_calibration as apply_calibration,
    forget_threshold as forget_threshold,
    save_threshold as save_threshold,
)
from overview_dsp.signal.actuators.library import actuator_names, load_actuator
from overview_dsp.signal.actuators.model import ACTUATOR_PARAMETERS, Actuator as Actuator
from overview_dsp.signal.actuators.resonance import (
    ResonanceFit as ResonanceFit,
    fit_resonance as fit_resonance,
)
from overview_dsp.signal.actuators.stage import (
    ActuatorStage as ActuatorStage,
    ProtectionReport as ProtectionReport,
)
from overview_dsp.signal.actuators.sweep import log_sweep as log_sweep

PARAMETERS = ACTUATOR_PARAMETERS
load = load_actuator
names = actuator_names
