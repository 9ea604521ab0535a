/* Uses the library of dinner.cpp. */
#include <stdio.h>

unsigned long long dinner_steps(unsigned long long seed);

int main(void) {
  const unsigned long long steps = dinner_steps(4);
  printf("%llu steps\n", steps);
  return steps == 5 ? 0 : 1;
}
