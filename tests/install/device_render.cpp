// bsdfkit_device_render.h as C++17: the same program.
#include "device_render.c"
