/* With second.c: two files of one program, both with the header. */
#include "sss_resample.h"

int second(sss_medium *m);

int main(void) {
    sss_medium m;
    return second(&m) || !(sss_profile(&m, 0, 1.0f) > 0.0f);
}
