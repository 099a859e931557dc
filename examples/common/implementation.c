// The bodies of both headers, once, for all examples that are linked with this folder.
#define MSSM_IMPLEMENTATION
#include "../../mssm.h"

#define LIGHTPROBE_IMPLEMENTATION
#include "../../lightprobe.h"
