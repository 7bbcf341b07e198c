__version__: str

from .errors import (
    ConfigError as ConfigError,
    ConvergenceError as ConvergenceError,
    DamagedError as DamagedError,
    FibermeltError as FibermeltError,
    HistoryError as HistoryError,
    MeshError as MeshError,
    StoreError as StoreError,
)
from .fiber.cell import solve_cell as solve_cell
from .fiber.extremes import (
    extremes as extremes,
    statistics as statistics,
)
from .fiber.jeffery import unbounded_ellipse as unbounded_ellipse
from .fiber.models import unbounded_model as unbounded_model
from .fiber.motion import (
    follow as follow,
    isotropic_angles as isotropic_angles,
    paper_angles as paper_angles,
)
from .fiber.orbit import orbit as orbit
from .fiber.pressure import (
    pressure_bounds as pressure_bounds,
    surface_pressure as surface_pressure,
)
from .fiber.shape import Ellipse as Ellipse
from .fiber.stall import stall_curve as stall_curve
from .fiber.tumbling import tumble as tumble
from .fields.field import Field as Field
from .fields.mapping import FieldMap as FieldMap
from .fields.reading import (
    describe_field as describe_field,
    read_field as read_field,
)
from .flow.deposition import solve_deposition as solve_deposition
from .flow.problem import (
    BeadDeposition as BeadDeposition,
    BeadNumerics as BeadNumerics,
    Deposition as Deposition,
    FlowNumerics as FlowNumerics,
    Nozzle as Nozzle,
)
from .flow.space.bead import solve_bead as solve_bead
from .flow.streamlines import trace_streamlines as trace_streamlines
from .flow.vtu import write_vtu as write_vtu
from .front import (
    open_results as open_results,
    run_study as run_study,
    sweep as sweep,
)
from .history import (
    FlowHistory as FlowHistory,
    simple_shear as simple_shear,
)
from .melt import (
    CarreauYasuda as CarreauYasuda,
    Cross as Cross,
    CrossWLF as CrossWLF,
    Newtonian as Newtonian,
    PowerLaw as PowerLaw,
)
from .orientation.closures import closure as closure
from .orientation.evolve import follow_orientation as follow_orientation
from .orientation.fokker_planck import steady_distribution as steady_distribution
from .orientation.models import FolgarTucker as FolgarTucker
from .orientation.steady import steady_state as steady_state
from .report import plot as plot
