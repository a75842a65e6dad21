"""Writes basin.msh (Gmsh 4.1, text): quadrilaterals whose rows follow the basin's floor."""

from math import cos, pi
from pathlib import Path

HALF, DEPTH, SIZE = 300.0, 100.0, 10.0
COLUMNS = round(2 * HALF / SIZE)
SOFT, ROCK = 2, 6


def floor(x):
    """Thickness of the basin at x, m."""
    return 5.0 + 25.0 * cos(0.5 * pi * x / HALF) ** 2


def height(i, j):
    """z of the node of column i and row j, counted from the bottom."""
    thickness = floor(-HALF + SIZE * i)
    if j <= ROCK:
        return -DEPTH + (DEPTH - thickness) * j / ROCK
    return -thickness * (1.0 - (j - ROCK) / SOFT)


def node(i, j):
    return 1 + i + (COLUMNS + 1) * j


rows = SOFT + ROCK
nodes = [(-HALF + SIZE * i, height(i, j)) for j in range(rows + 1) for i in range(COLUMNS + 1)]
lines = {
    "bottom": [(node(i, 0), node(i + 1, 0)) for i in range(COLUMNS)],
    "x_max": [(node(COLUMNS, j), node(COLUMNS, j + 1)) for j in range(rows)],
    "top": [(node(i + 1, rows), node(i, rows)) for i in range(COLUMNS)],
    "x_min": [(node(0, j + 1), node(0, j)) for j in range(rows)],
}
quads = {
    name: [
        (node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)) for j in band for i in range(COLUMNS)
    ]
    for name, band in {"rock": range(ROCK), "basin": range(ROCK, rows)}.items()
}
groups = [(1, name) for name in lines] + [(2, name) for name in quads]
bounds = f"{-HALF:g} 0 {-DEPTH:g} {HALF:g} 0 0"
text = ["$MeshFormat", "4.1 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(groups))]
text += [f'{dimension} {tag} "{name}"' for tag, (dimension, name) in enumerate(groups, 1)]
text += ["$EndPhysicalNames", "$Entities", f"0 {len(lines)} {len(quads)} 0"]
text += [f"{tag} {bounds} 1 {tag} 0" for tag in range(1, len(groups) + 1)]
text += ["$EndEntities", "$Nodes", f"1 {len(nodes)} 1 {len(nodes)}", f"2 {len(groups)} 0 {len(nodes)}"]
text += [str(tag) for tag in range(1, len(nodes) + 1)]
text += [f"{x:.10g} 0 {z:.10g}" for x, z in nodes]
count = sum(len(cells) for cells in [*lines.values(), *quads.values()])
text += ["$EndNodes", "$Elements", f"{len(groups)} {count} 1 {count}"]
tag = 0
for entity, (dimension, name) in enumerate(groups, 1):
    cells = (lines if dimension == 1 else quads)[name]
    text.append(f"{dimension} {entity} {1 if dimension == 1 else 3} {len(cells)}")
    for cell in cells:
        tag += 1
        text.append(" ".join(map(str, (tag, *cell))))
text.append("$EndElements")
Path(__file__).with_name("basin.msh").write_text("\n".join(text) + "\n", encoding="ascii")
