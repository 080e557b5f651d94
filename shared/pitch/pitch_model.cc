#include "shared/pitch/pitch_model.h"
