// Box of hexahedra, extruded; the volume runs downward so that Gmsh's lines may face any way.
Point(1) = {0, 0, 0}; Point(2) = {2, 0, 0}; Point(3) = {2, 1, 0}; Point(4) = {0, 1.5, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve{1, 3} = 4; Transfinite Curve{2, 4} = 3;
Transfinite Surface{1}; Recombine Surface{1};
Extrude {0, 0, 0.5} { Surface{1}; Layers{2}; Recombine; }
Physical Surface("base") = {1};
Physical Surface("wall") = {13, 17, 21, 25};
Physical Surface("lid") = {26};
Physical Volume("block") = {1};
