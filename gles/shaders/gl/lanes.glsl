// Edges are also compiled for several pixels at a time (mixed_edges.cpp). There a bool is one for each of them, ANY()
// is whether one is true, and EITHER() chooses for each.
#if defined(GL_ES)
#define ANY(flag) (flag)
#define EITHER(flag, yes, no) ((flag) ? (yes) : (no))
#endif
