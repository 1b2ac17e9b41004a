/* The header twice. */
#include "sss_resample.h"
#include "sss_resample.h"
typedef int not_empty;
