// SPDX-License-Identifier: BSD-3-Clause
// Background grid: unstructured triangles over the box 0 <= x <= 0.40 m, 0 <= y <= 0.15 m.
//     gmsh -2 -format msh41 grid.geo
h = 0.005;       // cell size [m]
length = 0.40;  // [m]
height = 0.15;  // [m]

Point(1) = {0, 0, 0, h};
Point(2) = {length, 0, 0, h};
Point(3) = {length, height, 0, h};
Point(4) = {0, height, 0, h};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};

Physical Curve("bottom") = {1};
Physical Curve("right") = {2};
Physical Curve("top") = {3};
Physical Curve("left") = {4};
Physical Surface("domain") = {1};

Mesh.Algorithm = 6;  // frontal-Delaunay: unstructured, well-shaped
