"""The pictures of the pages: file, width, and the command that draws each, with the runs that it needs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Picture:
    """A picture of a page.

    file, width
        File in `docs`, and its width (pixels).
    drawn
        File in the work folder that is the picture before it is reduced.
    command
        Command that writes it; empty if one of the runs does.
    needs
        Runs on whose results it stands.
    """

    file: str
    width: int
    drawn: str
    command: str = ""
    needs: tuple[str, ...] = ()


# Arguments of `amb-cosim`, or of python, by the folder of the results.
RUNS = {
    "fan": "-m tools.gallery.fan fan",
    "exp": "new exp --mass '40 kg' --length '0.8 m' --speed '18000 rpm'",
    **{name: f"run {name} -o {name}" for name in ("fig4_9", "fig4_18", "drop", "drop_mount", "relevitation", "run_up")},
    "landing": "run exp/landing.toml -o landing",
    "levitation": "run exp/levitation.toml -o levitation",
    "rolac": "compare fig5_6_pid fig5_6 -o rolac",
    "mounts": "compare drop drop_mount -o mounts",
    "phase": "sweep phase -o phase",
    "rolling": "sweep rolling -o rolling",
    "recovery": "sweep recovery -o recovery --sample boundary:recovered",
}


def _of_run(name: str, figure: str, run: str, width: int = 900, file: str = "", needs: tuple[str, ...] = ()) -> Picture:
    return Picture(file or f"gallery/{name}.png", width, f"{run}/{figure}.png", needs=(*needs, run))


def _of_study(
    name: str, arguments: str = "", file: str = "", needs: tuple[str, ...] = (), width: int = 1000
) -> Picture:
    study = arguments.partition(" ")[0]
    folder = f"study_{name}"
    return Picture(
        file or f"gallery/{name}.png", width, f"{folder}/{study}.png", f"study {arguments} -o {folder}", needs
    )


EXP = ("exp",)
LEVITATION = "exp/levitation.toml"
LEAD = Path(__file__).parents[2] / "examples" / "controllers" / "lead_notches.toml"

PICTURES = {
    "orbits": _of_run("orbits", "orbits", "fig4_9", 1000, "fig4_9_orbits.png"),
    "radius": _of_run("radius", "displacement", "fig4_9", 1000, "fig4_9_displacement.png"),
    "rub": _of_run("rub", "contact", "fig4_9", 1000, "fig4_9_contact.png"),
    "displacement": _of_run("displacement", "displacement", "drop", 1000),
    "contact": _of_run("contact", "contact", "drop", 1100),
    "magnets": _of_run("magnets", "magnets", "fig4_9"),
    "landing": _of_run("landing", "touchdown", "relevitation", 900),
    "landing_moves": Picture(
        "gallery/landing.gif", 900, "landing.gif", "plot relevitation landing -o landing.gif", ("relevitation",)
    ),
    "landing_contact": _of_run("landing_contact", "contact", "landing", 1100, needs=EXP),
    "whirl": _of_run("whirl", "whirl", "fig4_18", 1000, "fig4_18_whirl.png"),
    "turns": Picture("gallery/turns.png", 700, "turns.png", "plot levitation turns -o turns.png", (*EXP, "levitation")),
    "energy": Picture("gallery/energy.png", 800, "energy.png", "plot fig4_9 energy -o energy.png", ("fig4_9",)),
    "traces": Picture(
        "gallery/traces.png",
        800,
        "traces.png",
        "plot fig4_9 'mb1.[xy]' 'rb?.f_n' mb1.i_x --begin 'cycle 4' --until 'cycle 14.5' -o traces.png",
        ("fig4_9",),
    ),
    "compare": _of_run("compare", "orbits", "rolac"),
    "compare_contact": _of_run("compare_contact", "contact", "mounts", 1000, needs=("drop", "drop_mount")),
    "rotor": Picture("gallery/rotor.png", 900, "rotor.png", "rotor show compressor -o rotor.png"),
    "campbell": _of_study("campbell", "campbell", "rig_campbell.png"),
    "modes": _of_study("modes", "modes", "rig_modes.png", width=1600),
    "unbalance": _of_study("unbalance", f"unbalance_response {LEVITATION}", needs=EXP, width=1200),
    "poles": _of_study("poles", f"poles {LEVITATION}", needs=EXP),
    "sensitivity": _of_study("sensitivity", "sensitivity compressor_levitated", "sensitivity.png", width=1300),
    "linearisation": _of_study("linearisation", "linearisation", "linearisation.png"),
    "receptance": _of_study("receptance", "receptance", width=900),
    "response": _of_study(
        "response",
        "response --rotor compressor --input impeller1.f_x --response mb1.x --response impeller1.x",
        width=900,
    ),
    "fit": _of_study(
        "fit",
        "fit --rotor fan/fan.toml --measured fan/impact.csv"
        " --free bodies.wheel.mass=3:6 --free damping.modal=0.001:0.02",
        needs=("fan",),
        width=900,
    ),
    "controller": Picture(
        "gallery/controller.png",
        800,
        "controller.png",
        f"controller show '{LEAD}' --rotor compressor -o controller.png",
    ),
    "traps": _of_study(
        "traps", "traps fig5_6_pid --up-to '2483 rpm' --unbalance-up-to '60 g.m'", "traps.png", width=1300
    ),
    "stability_map": _of_study("stability_map", f"traps {LEVITATION}", needs=EXP, width=1000),
    "waterfall": _of_study("waterfall", "waterfall run_up", needs=("run_up",), width=1000),
    "robustness": _of_study("robustness", "robustness fig5_6", width=900),
    "convergence": _of_study("convergence", "convergence compressor_touchdown", width=900),
    "coupling": _of_study("coupling", "coupling", width=800),
    "phase": _of_run("phase", "phase", "phase", 700, "sweep_phase.png"),
    "rolling": _of_run("rolling", "rolling", "rolling", 700, "sweep_rolling.png"),
    "recovery": _of_run("recovery", "outcome", "recovery", 1460, "sweep_recovery.png"),
}
