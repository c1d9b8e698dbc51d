"""Notes on the damping of shafts, which models in time approximate."""

from __future__ import annotations

from amb_cosim.cosim.system.assembly import Assembly


def viscous_losses(assembly: Assembly) -> list[str]:
    """Return a sentence for each rotor whose loss factor is approximated by viscous damping (`hysteresis`)."""
    losses = {name: (fmu.layout or {}).get("loss_factor", 0.0) for name, fmu in assembly.fmus.items()}
    return [
        f"{name}: loss_factor = {eta:g} acts as viscous damping with equal loss in the elastic modes of the free rotor "
        "at rest; on stiff supports it is too weak, and its effect on whirl slower than the spin grows with the spin "
        "('study campbell' has the loss factor itself)"
        for name, eta in losses.items()
        if eta
    ]
