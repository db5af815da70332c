SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 2, 1};
MeshSize{:} = 0.8;
Physical Surface("all") = {1, 2, 3, 4, 5, 6};
Physical Volume(7) = {1};
