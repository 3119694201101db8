/// LCM addresses: what to do about one that could not be opened, in words for whoever gave it.
#ifndef SSV_ADDRESS_H
#define SSV_ADDRESS_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Room for the longest advice.
#define SSV_ADVICE_SIZE 192

/// A sentence without its end: what is wrong with the address, or where it is sound, what its provider needs.
void ssv_address_advice(const char* url, char advice[SSV_ADVICE_SIZE]);

#ifdef __cplusplus
}
#endif

#endif
