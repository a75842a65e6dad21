// Rock of 20 m under 10 m of clay, 60 m by 40 m, in hexahedra of 5 m; lengths in m, z up, surface at z = 0.
size = 5;
Point(1) = {0, 0, -30}; Point(2) = {60, 0, -30}; Point(3) = {60, 40, -30}; Point(4) = {0, 40, -30};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve{1, 3} = 60/size + 1;
Transfinite Curve{2, 4} = 40/size + 1;
Transfinite Surface{1};
Recombine Surface{1};

// Extruded upwards layer by layer: both layers share the surface between them and its nodes.
rock[] = Extrude{0, 0, 20}{ Surface{1}; Layers{20/size}; Recombine; };
clay[] = Extrude{0, 0, 10}{ Surface{rock[0]}; Layers{10/size}; Recombine; };

// Materials are volumes, boundaries are surfaces; hati knows them by these names.
Physical Volume("rock") = {rock[1]};
Physical Volume("clay") = {clay[1]};
Physical Surface("top") = {clay[0]};
Physical Surface("bottom") = {1};
Physical Surface("sides") = {rock[{2:5}], clay[{2:5}]};

// 1: straight edges (hex8), 2: curved ones (hex27). The order of the waves is a value of the scene.
Mesh.ElementOrder = 1;
