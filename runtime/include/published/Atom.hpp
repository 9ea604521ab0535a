// Classes behind external ports include this header in the published form. What they use of atoms is their ports.
#pragma once
#include "AtomExternalPort.hpp"
