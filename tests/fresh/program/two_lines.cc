#include <vector>
int main(int count, char**) { return std::vector<int>(count).empty() ? 1 : 0; }
