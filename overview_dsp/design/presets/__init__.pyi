"""Public names of `ov.presets`, each imported when it is first used."""

from overview_dsp.design.presets.comparing import (
    Difference as Difference,
    differences as differences,
)
from overview_dsp.design.presets.library import (
    bundled_presets,
    load_preset,
    user_presets as user_presets,
)
from overview_dsp.design.presets.model import (
    ClickMode as ClickMode,
    EventKind as EventKind,
    Preset as Preset,
    Tags as Tags,
)
from overview_dsp.design.presets.morphing import morph as morph, randomize as randomize
from overview_dsp.design.presets.parameter import Parameter as Parameter
from overview_dsp.design.presets.parameters import (
    KIND_PARAMETERS as KIND_PARAMETERS,
    MODE_PARAMETERS as MODE_PARAMETERS,
    PARAMETERS as PARAMETERS,
)
from overview_dsp.design.presets.writing import save_preset

bundled = bundled_presets
load = load_preset
save = save_preset
