/* The header alone. */
#include "sss_resample.h"
typedef int not_empty;
