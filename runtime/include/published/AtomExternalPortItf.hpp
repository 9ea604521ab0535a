// The published engine declares the interface of AtomExternalPort here.
#pragma once
#include "AtomExternalPort.hpp"

using AtomExternalPortItf = AtomExternalPort;
