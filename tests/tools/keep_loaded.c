/* keep_loaded.c - dlclose() that closes nothing. Linked into a program under AddressSanitizer, it
   keeps the names of libraries known until the leak check at the end, where some of them are
   forgiven. SPDX-License-Identifier: MIT */
int dlclose(void *library);
int dlclose(void *library) { return library == 0; }
