"""A small rotor as a file: an impeller between two bearings."""

SHAFT = """
name = "pump"
[shaft]
nodes = [0.0, 0.3, 0.6, 0.9]
diameter = 0.04
youngs_modulus = 2.1e11
density = 7800.0
poissons_ratio = 0.3
"""
IMPELLER = """
[[bodies]]
name = "impeller"
node = 2
mass = 20.0
radius = 0.1
width = 0.02
"""
LEVITATED = f"""{SHAFT}{IMPELLER}
[[bearings]]
name = "left"
node = 1
[[bearings]]
name = "right"
node = 4
[reduction]
masters = [1, 2, 4]
"""
UNSTABLE = f"""{SHAFT}{IMPELLER}
[[bearings]]
name = "left"
node = 1
stiffness = [[1e6, 5e5], [-5e5, 1e6]]
damping = 100.0
[[bearings]]
name = "right"
node = 4
stiffness = 1e6
"""


def sensors(*nodes: int) -> str:
    return "".join(f'[[sensors]]\nname = "plane{k}"\nnode = {node}\n' for k, node in enumerate(nodes))
