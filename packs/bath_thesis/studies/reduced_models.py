"""Study of full, condensed and coarse-mesh models of the rig (thesis Figs 3.4 to 3.7, Tables 3.1 and 3.4)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from amb_analysis.studies.inputs import Number, positive, speed_range
from amb_analysis.studies.result import DrawnResult
from amb_cosim.presentation.json_data import Layout
from amb_cosim.presentation.text_tables import TextBlock, labelled_table, number
from amb_cosim.presentation.units import speed_unit
from array_types import Array
from bath_thesis.meshes import mesh_family
from bath_thesis.printed import table_of
from bath_thesis.studies.frequency_tables import COUNT, MASSES, SPEEDS
from rotor_analysis.assembly import Matrices
from rotor_analysis.campbell import Campbell
from rotor_analysis.campbell import campbell as follow_modes
from rotor_analysis.modes import damped_frequencies
from rotor_analysis.response import orbit
from rotor_analysis.response import unbalance_response as steady_response
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.supported_rotor import SupportedRotor, supported_rotor

POINTS = 251  # speeds of the curves
FULL, CONDENSED, COARSE = "13_node", "condensed", "6_node"
DRAWN = (FULL, CONDENSED, COARSE)


@dataclass(frozen=True, eq=False)
class ReducedModel:
    """Results of one model as a function of spin speed.

    coordinates
        Number of its degrees of freedom.
    frequencies
        Damped natural frequencies (rad/s), shape (modes, n); NaN where a mode does not oscillate.
    critical_speeds
        Critical speeds (rad/s).
    displacement
        Largest amplitude at the planes of discs and bearings (m), shape (n,).
    """

    coordinates: int
    frequencies: Annotated[Array, "rad/s"]
    critical_speeds: Annotated[tuple[float, ...], "rad/s"]
    displacement: Annotated[Array, "m"]


@dataclass(frozen=True)
class MeanError:
    """Mean absolute error of eight frequencies at 90, 120 and 145 rad/s, relative to the 23-node consistent-mass model.

    computed, thesis
        Computed error (%), and the error in the thesis (%); None where the thesis states no error.
    mass, diametral_inertia
        Rigid-body mass (kg) of the model, and its diametral inertia about the centre of mass (kg m^2); None if the
        model is condensed.
    """

    computed: Annotated[float, "%"]
    thesis: Annotated[float | None, "%"]
    mass: Annotated[float | None, "kg", Layout.OMITTED_IF_NONE] = None
    diametral_inertia: Annotated[float | None, "kg.m2", Layout.OMITTED_IF_NONE] = None


@dataclass(frozen=True, eq=False)
class FrequenciesBeside:
    """Computed frequencies, those of the thesis (rad/s), and the deviations between them (%), each of shape (8,)."""

    computed: Annotated[Array, "rad/s"]
    thesis: Annotated[Array, "rad/s"]
    deviation: Annotated[Array, "%"]


@dataclass(frozen=True, eq=False, repr=False)
class ModelReduction(DrawnResult):
    """Models of the rig: with 13 nodes, condensed to six planes, and with six nodes.

    unbalance, node
        Unbalance that causes the response (kg m), and the node at which it acts.
    speeds
        Spin speeds of the curves (rad/s), shape (n,).
    models
        Results of the three models over the spin speed, with diagonal mass.
    largest_response_error
        Largest deviation of the amplitudes of the other two models from the full model (%).
    mean_errors
        Errors of the frequencies by model and mass matrix (Figs 3.4, 3.5).
    frequencies
        Frequencies by model, mass matrix and speed (rad/s), compared with Tables 3.1 (19 nodes) and 3.4 (6 nodes).
    printed_change
        Relative difference (%) between the printed frequencies for 6 and for 13 nodes, with diagonal mass at 90 rad/s.
    """

    name: ClassVar[str] = "reduction"

    unbalance: Annotated[float, "kg.m"]
    node: int
    speeds: Annotated[Array, "rad/s"]
    models: dict[str, ReducedModel]
    largest_response_error: Annotated[dict[str, float], "%"]
    mean_errors: dict[str, dict[str, MeanError]]
    frequencies: dict[str, dict[str, dict[str, FrequenciesBeside]]]
    printed_change: Annotated[Array, "%"]

    def text(self) -> list[TextBlock]:
        """Return the errors of the models, the comparison with the thesis, and the reason why 6 nodes disagree."""
        unit = speed_unit()
        *slower, fastest = map(unit.number, SPEEDS)
        title = f"Mean error of eight frequencies at {', '.join(slower)} and {fastest} {unit.label} (%)"
        errors = labelled_table(title, "model", "mass matrix", "computed", "thesis", "rigid inertia (kg m2)")
        for model, masses in self.mean_errors.items():
            for mass, row in masses.items():
                inertia = number(row.diametral_inertia)
                errors.add_row(model.replace("_", " "), mass, f"{row.computed:.4f}", number(row.thesis), inertia)
        title = "Deviation from Tables 3.1 and 3.4 (%)"
        heads = ("mass matrix", f"speed ({unit.label})", *(str(k + 1) for k in range(COUNT)))
        deviations = labelled_table(title, "model", *heads)
        for model, by_mass in self.frequencies.items():
            for mass, by_speed in by_mass.items():
                for speed, frequencies in by_speed.items():
                    cells = (f"{value:z.2f}" for value in frequencies.deviation)
                    deviations.add_row(model.replace("_", " "), mass, unit.number(float(speed)), *cells)
        response = ", ".join(f"{error:.2g} % {name}" for name, error in self.largest_response_error.items())
        amplitudes = f"amplitudes deviate from those of the full model by up to {response.replace('_', ' ')}"
        return [errors, deviations, amplitudes, self._reason()]

    def _reason(self) -> str:
        lumped, full = (self.mean_errors[model]["diagonal"] for model in (COARSE, FULL))
        more = 100.0 * ((lumped.diametral_inertia or np.nan) / (full.diametral_inertia or np.nan) - 1.0)
        first, third = self.printed_change[0], self.printed_change[4]
        inertia = 100.0 / (1.0 + 0.01 * first) ** 2
        return (
            "The coarse mesh has the same discs, cores and bearings at the same positions, and the same mass. Its "
            "consistent matrices bound the frequencies of finer meshes from above (Ritz), and its lumped matrices "
            f"raise the diametral inertia by {more:.1f} %, which lowers the conical mode. The first frequency printed "
            f"for 6 nodes is {first:.0f} % higher than the one printed for 13 nodes. This would require a reduction of "
            f"the inertia to {inertia:.0f} %. However, the frequencies printed for the third pair are {-third:.0f} % "
            "lower. The printed frequencies are therefore not those of a coarser mesh of the same rotor."
        )


def reduction(*, up_to: Number = "4775 rpm", unbalance: Number = "0.5 g.m") -> ModelReduction:
    """Return frequencies, unbalance response and errors of the rig with 13 nodes, condensed, and with 6 nodes.

    Parameters
    ----------
    up_to
        Highest spin speed of the curves (rad/s), or a string with its unit.
    unbalance
        Unbalance on the disc at the non-driven end (kg m), or a string with its unit.

    Raises
    ------
    ValueError
        If an argument is out of range.
    """
    u, speeds = positive(unbalance, "kg.m", "unbalance"), speed_range(up_to, POINTS)[1:]
    rotor, printed = load_rotor("bath_rig_thesis"), table_of("reduction")
    meshes = {f"{count}_node": mesh for count, mesh in mesh_family(rotor).items()}
    built = {model: {mass: supported_rotor(mesh, mass) for mass in MASSES} for model, mesh in meshes.items()} | {
        CONDENSED: {mass: supported_rotor(rotor, mass, rotor.masters) for mass in MASSES}
    }
    rows = {
        model: {mass: _rows(rotor_model.model) for mass, rotor_model in by_mass.items()}
        for model, by_mass in built.items()
    }
    finest = rows[max(meshes, key=lambda model: len(meshes[model].shaft.nodes))]["consistent"]
    coarse_planes = tuple(range(1, len(rotor.masters) + 1))
    planes = {FULL: rotor.masters, CONDENSED: rotor.masters, COARSE: coarse_planes}
    models = {model: _over_speed(built[model]["diagonal"], speeds, u, planes[model]) for model in DRAWN}
    response_errors = {
        model: float(100.0 * np.abs(models[model].displacement / models[FULL].displacement - 1.0).max())
        for model in (CONDENSED, COARSE)
    }
    errors: dict[str, dict[str, MeanError]] = {
        model: {
            mass: _mean_error(built[model][mass], frequencies, finest, printed["mean_error"].get(model, {}).get(mass))
            for mass, frequencies in by_mass.items()
        }
        for model, by_mass in rows.items()
    }
    beside = {
        model: {mass: _beside(rows[model][mass], by_speed) for mass, by_speed in printed[model].items()}
        for model in ("19_node", COARSE)
    }
    change = 100.0 * (beside[COARSE]["diagonal"]["90"].thesis / table_of("frequencies")[FULL]["diagonal"]["90"] - 1.0)
    return ModelReduction(u, rotor.masters[0], speeds, models, response_errors, errors, beside, change)


def rigid_inertia(model: Matrices, z: Array) -> tuple[float, float]:
    """Return mass (kg), and diametral inertia about the centre of mass (kg m^2), of a finite-element model.

    Parameters
    ----------
    model
        Matrices with displacements and slopes of all nodes.
    z
        Axial position of the nodes (m), shape (nodes,).
    """
    M = model.M[::2, ::2]
    along, turning = np.zeros((2, len(M)))
    along[::2] = 1.0
    turning[::2], turning[1::2] = z, 1.0
    mass = float(along @ M @ along)
    return mass, float(turning @ M @ turning - (along @ M @ turning) ** 2 / mass)


def _rows(model: Matrices) -> Array:
    """Return the first eight damped frequencies at the three speeds (rad/s), shape (3, 8)."""
    return np.array([damped_frequencies(model, speed, COUNT) for speed in SPEEDS])


def _mean_error(model: SupportedRotor, frequencies: Array, finest: Array, thesis: float | None) -> MeanError:
    error = 100.0 * float(np.mean(np.abs(frequencies / finest - 1.0)))
    if model.model.size < 4 * len(model.nodes):
        return MeanError(error, thesis)
    return MeanError(error, thesis, *rigid_inertia(model.model, np.array(model.rotor.shaft.nodes)))


def _beside(frequencies: Array, printed: dict[str, list[float]]) -> dict[str, FrequenciesBeside]:
    """Return the computed and the printed frequencies, by speed."""
    return {
        speed: FrequenciesBeside(row, np.array(numbers), 100.0 * (row / np.array(numbers) - 1.0))
        for row, (speed, numbers) in zip(frequencies, printed.items(), strict=True)
    }


def _over_speed(model: SupportedRotor, speeds: Array, unbalance: float, planes: tuple[int, ...]) -> ReducedModel:
    """Return frequencies and response of a model with unbalance at the first plane."""
    diagram: Campbell = follow_modes(model.model, speeds, COUNT)
    major, _, _ = orbit(steady_response(model, {planes[0]: unbalance}, speeds, planes))
    critical = tuple(crossing.Omega for crossing in diagram.critical_speeds)
    return ReducedModel(model.model.size, diagram.frequencies, critical, major.max(axis=1))
