//! Files into descriptions: Mitsuba 3 XML, OBJ, PLY, serialized, VOL.
