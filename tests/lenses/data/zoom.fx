# Made-up zoom
// for the tests
#!scale 0.5
97.0    8         abbe   1.62041 60.32  20      // crown
-240.5  3.0       N-SF2  1.64769 33.79  19.5
inf     7/12/18.5 air                   19      // varies
10000   4         IRIS                  12.5
140.0   6         abbe   1.5168  64.2   16      #!aspheric=-1,1e-5,-2e-8,0,0
-105.0  80.5 / 91 air                   16.5
