from .closures import (
    CLOSURES as CLOSURES,
    Closure as Closure,
)
from .evolve import (
    OrientationHistory as OrientationHistory,
    follow_orientation as follow_orientation,
)
from .flows import (
    FLOWS as FLOWS,
    flow_gradient as flow_gradient,
)
from .models import (
    ARDRSC as ARDRSC,
    IARD as IARD,
    MODELS as MODELS,
    MRD as MRD,
    PARD as PARD,
    RSC as RSC,
    FolgarTucker as FolgarTucker,
    Jeffery as Jeffery,
    Nematic as Nematic,
    OrientationModel as OrientationModel,
    model_class as model_class,
    shape_factor as shape_factor,
)
from .steady import (
    SteadyState as SteadyState,
    steady_state as steady_state,
)
from .tensors import (
    isotropic as isotropic,
    out_of_range as out_of_range,
    preferred_angle as preferred_angle,
    principal as principal,
)
