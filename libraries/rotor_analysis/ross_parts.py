"""The parts in a file saved by ROSS, unchanged."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

AXES = ("xx", "xy", "yx", "yy")
DRAWING = {"color", "scale_factor", "tag"}
STRICT = ConfigDict(strict=True, allow_inf_nan=False)


class SavedMaterial(BaseModel):
    """A material, with E and G_s in Pa and rho in kg/m^3."""

    model_config = STRICT

    name: str
    rho: float
    E: float
    G_s: float


class SavedElement(BaseModel):
    """The data that every part has: its name and its node number, counted from 0."""

    model_config = STRICT

    tag: str
    n: int = Field(ge=0)


class SavedShaftElement(SavedElement):
    """An element of the shaft from its node to the next; l and r denote its ends, alpha and beta its damping."""

    L: float = Field(gt=0.0)
    odl: float
    odr: float
    idl: float
    idr: float
    material: SavedMaterial
    axial_force: float = 0.0
    torque: float = 0.0
    shear_effects: bool = True
    rotary_inertia: bool = True
    gyroscopic: bool = True
    shear_method_calc: str = "cowper"
    alpha: float = 0.0
    beta: float = 0.0


class SavedDisk(SavedElement):
    """A disc, with its mass (kg) and its diametral and polar moments of inertia (kg m^2)."""

    m: float
    Id: float
    Ip: float


class SavedMass(SavedElement):
    """A point mass (kg), which may differ between the axes."""

    mx: float
    my: float


class SavedBearing(SavedElement):
    """A bearing or seal: constant coefficients, or coefficients by `speed` or by whirl `frequency` (rad/s).

    Versions of ROSS before 3 use the name `frequency` for the speed; such an entry is read as `speed`.
    """

    model_config = ConfigDict(strict=True, allow_inf_nan=False, extra="allow")

    n_link: int | None = None
    interpolation: str = "pchip"
    speed: list[float] | None = None
    frequency: list[float] | None = None
    kxx: list[float]
    kxy: list[float]
    kyx: list[float]
    kyy: list[float]
    cxx: list[float]
    cxy: list[float]
    cyx: list[float]
    cyy: list[float]
    mxx: list[float] = []
    mxy: list[float] = []
    myx: list[float] = []
    myy: list[float] = []
    kzz: list[float] = []
    czz: list[float] = []
    mzz: list[float] = []
