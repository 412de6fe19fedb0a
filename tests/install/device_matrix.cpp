// bsdfkit_device_matrix.h as C++17: the same program.
#include "device_matrix.c"
