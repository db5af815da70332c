// Plate with a hole, triangles; upper and lower half are cell groups.
h = 0.35;
Point(1) = {0, 0, 0, h}; Point(2) = {2, 0, 0, h}; Point(3) = {2, 1, 0, h}; Point(4) = {0, 1, 0, h};
Point(5) = {1, 0.5, 0, h}; Point(6) = {1.25, 0.5, 0, h}; Point(7) = {0.75, 0.5, 0, h};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Circle(5) = {6, 5, 7}; Circle(6) = {7, 5, 6};
Line(7) = {7, 6};
Curve Loop(1) = {1, 2, 3, 4}; Curve Loop(2) = {5, 6};
Curve Loop(3) = {6, -7}; 
Plane Surface(1) = {1, 2};
Plane Surface(2) = {3};
Physical Curve("outside") = {1, 2, 3, 4};
Physical Curve("hole") = {5};
Physical Curve("between") = {6};
Physical Surface("plate") = {1};
Physical Surface("inlay") = {2};
