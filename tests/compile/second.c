#include "sss_resample.h"

int second(sss_medium *m);

int second(sss_medium *m) {
    const float albedo[3] = {0.5f, 0.5f, 0.5f};
    const float length[3] = {1.0f, 1.0f, 1.0f};
    return sss_burley(m, albedo, length) != SSS_OK;
}
