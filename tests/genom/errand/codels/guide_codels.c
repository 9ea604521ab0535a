/* Codels of guide. */
#include "acguide.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "guide_c_types.h"

genom_event
guideStart(uint32_t *asked, const genom_context self)
{
  (void)self;
  *asked = 0;
  return guide_ether;
}

genom_event
guideTally(const char name[8], sequence_double *times, errands_spot *last, char verdict[16],
           uint32_t *asked, const genom_context self)
{
  uint32_t k;
  if (++*asked > 3) {
    guiding_e_tired_detail d;
    d.asked = *asked;
    return guiding_e_tired(&d, self);
  }
  for (k = 0; k < times->_length; k++) times->_buffer[k] *= 2.;
  if (genom_sequence_reserve(times, times->_length + 1)) return guide_ether;
  times->_buffer[times->_length++] = *asked;
  last->x = times->_length;
  last->y = 0.5;
  last->name = strdup(name);
  snprintf(verdict, 16, "asked by %.6s", name);
  return genom_ok;
}

/* What the lookout saw, or the exception that it raised. */
genom_event
visitStart(const errands_spot *where, errands_weather weather, const optional_double *limit,
           errands_spots *seen, char **summary, double area[2], uint32_t *count,
           const guide_watch *watch, const genom_context self)
{
  const errands_grid size = {0.5, 2.5};
  genom_event raised, how;
  how = watch->call(where, weather, size, "guide", "as far as \"you\" can", limit, seen, summary, area, count, self);
  if (how == genom_ok) return guide_ether;
  if (how == watching_e_dark_id) {
    /* Its details are the caller's to see. */
    const watching_e_dark_detail *const dark = self->raised(&raised, self);
    if (raised != how || dark->weather != errands_FOG || strcmp(dark->since, "dawn")) return guide_ether;
  }
  return how;
}
