/* C codels, as genom3's skeletons have them. */
#include "aclamp.h"

#include <stdlib.h>
#include <string.h>

#include "lamp_c_types.h"

genom_event
showStart(const space_pose *where, bool is_spare, const lamp_beacon *beacon, const lamp_spare *spare, int32_t *shown,
          const genom_context self)
{
  ++*shown;
  if (is_spare) {
    *spare->data(self) = *where;
    spare->write(self);
  } else {
    *beacon->data(self) = *where;
    beacon->write(self);
  }
  return lamp_ether;
}

genom_event
lampSeen(const lamp_sight *sight, space_sighting *last, const genom_context self)
{
  space_sighting *s;
  uint32_t i;
  if (sight->read(self) != genom_ok) return genom_no_such_data(self);
  s = sight->data(self);
  if (!s) return genom_no_such_data(self);
  last->where = s->where;
  if (genom_sequence_reserve(&last->outline, s->outline._length)) return genom_no_such_data(self);
  for (i = 0; i < s->outline._length; i++) last->outline._buffer[i] = s->outline._buffer[i];
  last->outline._length = s->outline._length;
  if (genom_sequence_reserve(&last->hits, s->hits._length)) return genom_no_such_data(self);
  for (i = 0; i < s->hits._length; i++) last->hits._buffer[i] = s->hits._buffer[i];
  last->hits._length = s->hits._length;
  last->label = strdup(s->label ? s->label : "");
  memcpy(last->covariance, s->covariance, sizeof(last->covariance));
  return genom_ok;
}
