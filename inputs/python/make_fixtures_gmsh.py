"""Writes small meshes, sound ones and ones to be refused, for the tests of hati's mesh reader.

    python make_fixtures_gmsh.py FOLDER

Needs the package gmsh; its meshes are in git (inputs/tests/data/gmsh), so that the tests do without it.
Lengths are in m. The same Gmsh writes the same bytes.
"""

import os
import sys
import tempfile

import gmsh

# A section of 20 m by 10 m in Gmsh's plane x-y, two layers of 4 m and 6 m; the border of the lower layer
# runs clockwise, so that its quadrilaterals do too.
SECTION = """
Point(1) = {0, -10, 0}; Point(2) = {20, -10, 0}; Point(3) = {20, -4, 0};
Point(4) = {0, -4, 0}; Point(5) = {20, 0, 0}; Point(6) = {0, 0, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Line(5) = {3, 5}; Line(6) = {5, 6}; Line(7) = {6, 4};
Curve Loop(1) = {-4, -3, -2, -1}; Curve Loop(2) = {5, 6, 7, -3};
Plane Surface(1) = {1}; Plane Surface(2) = {2};
Transfinite Curve{1, 3, 6} = 5; Transfinite Curve{2, 4} = 4; Transfinite Curve{5, 7} = 3;
Transfinite Surface{1, 2}; Recombine Surface{1, 2};
Physical Surface("rock", 7) = {1}; Physical Surface("clay", 3) = {2};
Physical Curve("top", 1) = {6}; Physical Curve("bottom", 2) = {1}; Physical Curve("all", 9) = {1, 2, 4, 5, 6, 7};
"""

# The same in the plane x-z, the upper layer a hill under an arc: quadrilaterals with curved sides, free ones.
HILL = """
lc = 5;
Point(1) = {0, 0, -10, lc}; Point(2) = {20, 0, -10, lc}; Point(3) = {20, 0, -4, lc};
Point(4) = {0, 0, -4, lc}; Point(5) = {20, 0, 0, lc}; Point(6) = {0, 0, 0, lc}; Point(7) = {10, 0, -16, lc};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Line(5) = {3, 5}; Circle(6) = {5, 7, 6}; Line(7) = {6, 4};
Curve Loop(1) = {1, 2, 3, 4}; Curve Loop(2) = {-3, 5, 6, 7};
Plane Surface(1) = {1}; Plane Surface(2) = {2};
Recombine Surface{1, 2};
Physical Surface("rock") = {1}; Physical Surface("clay") = {2};
Physical Curve("top") = {6};
"""

# A block of 20 m by 10 m by 10 m, two layers of 6 m and 4 m, extruded upwards.
BLOCK = """
Point(1) = {0, 0, -10}; Point(2) = {20, 0, -10}; Point(3) = {20, 10, -10}; Point(4) = {0, 10, -10};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Transfinite Curve{1, 3} = 5; Transfinite Curve{2, 4} = 3;
Transfinite Surface{1}; Recombine Surface{1};
rock[] = Extrude{0, 0, 6}{ Surface{1}; Layers{2}; Recombine; };
clay[] = Extrude{0, 0, 4}{ Surface{rock[0]}; Layers{1}; Recombine; };
Physical Volume("rock") = {rock[1]}; Physical Volume("clay") = {clay[1]};
Physical Surface("bottom") = {1}; Physical Surface("top") = {clay[0]};
Physical Surface("contact") = {rock[0]};
"""

# A quarter of a ring, 4 m to 8 m in radius, 3 m high: hexahedra with curved faces.
RING = """
Point(1) = {4, 0, 0}; Point(2) = {8, 0, 0};
Line(1) = {1, 2}; Transfinite Curve{1} = 2;
s[] = Extrude{0, 0, 3}{ Curve{1}; Layers{1}; Recombine; };
v[] = Extrude{{0, 0, 1}, {0, 0, 0}, Pi/2}{ Surface{s[1]}; Layers{3}; Recombine; };
Physical Volume("ring") = {v[1]}; Physical Surface("outer") = {v[3]};
"""

TETRAHEDRA = """
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 1}; MeshSize{:} = 2;
Physical Volume("soil") = {1}; Physical Surface("top") = {6};
"""

# Two blocks side by side, drawn one by one: they touch and share no node.
APART = """
For i In {0:1}
  p = newp; Point(p) = {i, 0, 0}; Point(p+1) = {i+1, 0, 0}; Point(p+2) = {i+1, 1, 0}; Point(p+3) = {i, 1, 0};
  c = newc; Line(c) = {p, p+1}; Line(c+1) = {p+1, p+2}; Line(c+2) = {p+2, p+3}; Line(c+3) = {p+3, p};
  Transfinite Curve{c:c+3} = 2;
  l = newcl; Curve Loop(l) = {c:c+3}; Plane Surface(i+1) = {l}; Transfinite Surface{i+1}; Recombine Surface{i+1};
EndFor
Geometry.AutoCoherence = 0;
Physical Surface("soil") = {1, 2};
"""

SQUARE = """
Point(1) = {0, 0, 0}; Point(2) = {2, 0, 0}; Point(3) = {2, 2, 0}; Point(4) = {0, 2, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Transfinite Curve{:} = 2; Transfinite Surface{1}; Recombine Surface{1};
Physical Surface("soil") = {1}; Physical Curve("top") = {3};
"""

# Name, geometry, dimension, options.
FILES = [
    ("section_quad4.msh", SECTION, 2, {}),
    ("section_quad4_22.msh", SECTION, 2, {"Mesh.MshFileVersion": 2.2}),
    ("section_quad4_22_binary.msh", SECTION, 2, {"Mesh.MshFileVersion": 2.2, "Mesh.Binary": 1}),
    ("hill_quad4.msh", HILL, 2, {}),
    ("hill_quad9.msh", HILL, 2, {"Mesh.ElementOrder": 2, "Mesh.Binary": 1}),
    ("block_hex8.msh", BLOCK, 3, {}),
    ("block_hex8_binary.msh", BLOCK, 3, {"Mesh.Binary": 1}),
    ("block_hex8_22.msh", BLOCK, 3, {"Mesh.MshFileVersion": 2.2}),
    ("block_hex8_parametric.msh", BLOCK, 3, {"Mesh.Binary": 1, "Mesh.SaveParametric": 1}),
    ("block_hex27.msh", BLOCK, 3, {"Mesh.ElementOrder": 2, "Mesh.Binary": 1}),
    ("ring_hex8.msh", RING, 3, {}),
    ("ring_hex27.msh", RING, 3, {"Mesh.ElementOrder": 2}),
    ("ring_hex27_22_binary.msh", RING, 3, {"Mesh.ElementOrder": 2, "Mesh.MshFileVersion": 2.2, "Mesh.Binary": 1}),
    ("refused_tetrahedra.msh", TETRAHEDRA, 3, {}),
    ("refused_triangles.msh", SQUARE.replace("Recombine Surface{1};", ""), 2, {}),
    ("refused_quad8.msh", SQUARE, 2, {"Mesh.ElementOrder": 2, "Mesh.SecondOrderIncomplete": 1}),
    ("refused_order3.msh", SQUARE, 2, {"Mesh.ElementOrder": 3}),
    ("refused_hex20.msh", RING, 3, {"Mesh.ElementOrder": 2, "Mesh.SecondOrderIncomplete": 1}),
    ("refused_apart.msh", APART, 2, {}),
    ("refused_no_groups.msh", SQUARE.split("Physical")[0], 2, {}),
    ("refused_only_boundary.msh", RING.replace('Physical Volume("ring") = {v[1]};', ""), 3, {}),
    ("refused_partitioned.msh", SECTION, 2, {"partition": 2}),
    ("refused_version_40.msh", SQUARE, 2, {"Mesh.MshFileVersion": 4.0}),
    ("refused_version_1.msh", SQUARE, 2, {"Mesh.MshFileVersion": 1.0}),
]


def write(path, geometry, dimension, options):
    gmsh.clear()
    gmsh.option.restoreDefaults()
    gmsh.option.setNumber("General.Terminal", 0)
    for name, value in options.items():
        if name != "partition":
            gmsh.option.setNumber(name, value)
    with tempfile.TemporaryDirectory() as folder:
        source = os.path.join(folder, "model.geo")
        with open(source, "w") as file:
            file.write("Geometry.AutoCoherence = 0;\n" if geometry is APART else "")
            file.write(geometry)
        gmsh.open(source)
    gmsh.model.mesh.generate(dimension)
    if "partition" in options:
        gmsh.model.mesh.partition(options["partition"])
    gmsh.write(path)


def main(folder):
    os.makedirs(folder, exist_ok=True)
    gmsh.initialize(["gmsh", "-v", "0"], readConfigFiles=False)
    for name, geometry, dimension, options in FILES:
        write(os.path.join(folder, name), geometry, dimension, options)
    gmsh.finalize()


if __name__ == "__main__":
    main(sys.argv[1])
