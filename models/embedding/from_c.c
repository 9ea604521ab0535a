/* A model in a C program: candidates are listed, and the program chooses. */
#include <stdio.h>
#include <string.h>

#include "bip/bip.h"
#include "table.h"

int main(void) {
  bip_execution* table = bip_create(table_image(), 1, BIP_FIRST);
  if (table == NULL) return 1;
  char name[200];
  /* Everybody takes the left fork first: the deadlock. */
  while (bip_status(table) == BIP_STEPPED) {
    uint64_t chosen = 0;
    for (uint64_t k = 0; k < bip_candidate_count(table); ++k) {
      bip_candidate(table, k, name, sizeof name);
      if (strstr(name, ".left[") != NULL) chosen = k;
    }
    bip_candidate(table, chosen, name, sizeof name);
    if (bip_fire(table, chosen) == BIP_STEPPED) printf("%s\n", name);
  }
  char place[50];
  bip_place(table, "ROOT.table.phil[0]", place, sizeof place);
  printf("the first philosopher is at %s after %llu steps\n", place, (unsigned long long)bip_steps(table));
  const int as_expected = bip_status(table) == BIP_DEADLOCK && bip_steps(table) == 5 && strcmp(place, "HAS_LEFT") == 0;
  bip_destroy(table);
  return as_expected ? 0 : 1;
}
