// The part of libpleno's depthimage.cpp that the other files name; no calibration calls it.
#include <pleno/geometry/depth/depthimage.h>

DepthMapImage::DepthMapImage(DepthMap const&, PlenopticCamera const&, double, double) {}
