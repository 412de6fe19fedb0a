// bsdfkit_device.h as C++17: the same program.
#include "device.c"
